#include <zip.h>

#include <algorithm>
#include <fstream>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/base/zip_archive.h"

namespace cosplat {
namespace {

using Member = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

}  // namespace

void ZipReader::Discard::operator()(zip* archive) const { zip_discard(archive); }

ZipReader::ZipReader(const std::string& path, const std::string& kind) : path_(path) {
  int code = 0;
  archive_.reset(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (!archive_) {
    std::string begin(64, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(begin.data(), std::streamsize(begin.size()));
    begin.resize(size_t(std::max<std::streamsize>(file.gcount(), 0)));
    const std::string other = file.is_open() ? OtherContent(begin) : "";
    throw Error(
        path, other.empty() ? "cannot be read as " + kind + ": " + ReasonOfZipError(code) : other);
  }
  CheckTotal();
}

ZipReader::ZipReader(const std::string& path, const std::string& kind, std::vector<char> bytes)
    : path_(path), bytes_(std::move(bytes)) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(bytes_.data(), bytes_.size(), 0, &error);
  if (source) archive_.reset(zip_open_from_source(source, ZIP_RDONLY, &error));
  const std::string problem = archive_ ? "" : zip_error_strerror(&error);
  if (!archive_ && source) zip_source_free(source);
  zip_error_fini(&error);
  if (!archive_) throw Error(path, "cannot be read as " + kind + ": " + problem);
  CheckTotal();
}

void ZipReader::CheckTotal() const {
  uint64_t total = 0;
  zip_stat_t stat;
  for (size_t i = 0; i < size(); ++i) {
    const bool known =
        zip_stat_index(archive_.get(), i, 0, &stat) == 0 && (stat.valid & ZIP_STAT_SIZE);
    if (known && stat.size > kMaxArchiveBytes - total) throw TooMuchUnpacked(path_, stat.name);
    if (known) total += stat.size;
  }
}

size_t ZipReader::size() const { return size_t(zip_get_num_entries(archive_.get(), 0)); }

std::string ZipReader::Name(size_t index) const {
  const char* name = zip_get_name(archive_.get(), index, 0);
  return name != nullptr ? name : "";
}

size_t ZipReader::Find(const std::string& name) const {
  size_t index = 0;
  while (index < size() && Name(index) != name) ++index;
  return index;
}

std::vector<char> ZipReader::Read(size_t index, uint64_t limit) const {
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat_index(archive_.get(), index, 0, &stat) != 0 || !(stat.valid & ZIP_STAT_SIZE))
    throw Error(path_, "entry " + std::to_string(index), "cannot be read");
  if (stat.size > limit)
    throw Error(
        path_, stat.name, Format("has {} bytes, at most {} are accepted", stat.size, limit));
  const Member file(zip_fopen_index(archive_.get(), index, 0), zip_fclose);
  if (!file)
    throw Error(path_, stat.name, std::string("cannot be read: ") + zip_strerror(archive_.get()));
  // Grown while reading, since the size in a damaged directory cannot be trusted.
  std::vector<char> bytes;
  std::vector<char> block(size_t(std::min<uint64_t>(1 << 20, stat.size + 1)));
  zip_int64_t count = 0;
  while (bytes.size() <= stat.size &&
         (count = zip_fread(file.get(), block.data(), block.size())) > 0)
    bytes.insert(bytes.end(), block.data(), block.data() + count);
  if (count < 0)
    throw Error(path_,
                stat.name,
                std::string("is damaged: ") + zip_error_strerror(zip_file_get_error(file.get())));
  if (bytes.size() != stat.size)
    throw Error(path_, stat.name, Format("holds {} bytes, expected {}", bytes.size(), stat.size));
  return bytes;
}

}  // namespace cosplat

// Npz::Write: the one part of .npz files that needs libzip itself, not only ZipReader.
#include <zip.h>

#include <memory>
#include <utility>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/base/zip_reader.h"

namespace cosplat {
namespace {

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

// `bytes` must outlive the archive, since libzip only reads them on closing.
void AddMember(zip_t* archive,
               const std::string& path,
               const std::string& name,
               const std::string& bytes) {
  zip_source_t* source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
  const zip_int64_t index = zip_file_add(archive, name.c_str(), source, ZIP_FL_ENC_UTF_8);
  if (index < 0) {
    zip_source_free(source);
    throw Error(path, name, std::string("cannot be written: ") + zip_strerror(archive));
  }
  zip_file_set_mtime(archive, index, 315619200, 0);  // 1980: equal arrays give equal bytes
}

}  // namespace

std::string ReasonOfZipError(int code) {
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

void Npz::Write(const std::string& path) const {
  std::vector<std::pair<std::string, std::string>> members(texts_.begin(), texts_.end());
  for (const auto& [name, array] : arrays_) members.emplace_back(name + ".npy", FormatNpy(array));
  WriteViaTemporary(path, [&](const std::string& temporary) {
    int code = 0;
    Archive archive(zip_open(temporary.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code), zip_discard);
    if (!archive) throw Error(path, "cannot be written: " + ReasonOfZipError(code));
    for (const auto& [name, bytes] : members) AddMember(archive.get(), path, name, bytes);
    if (zip_close(archive.get()) != 0)
      throw Error(path, std::string("write failed: ") + zip_strerror(archive.get()));
    archive.release();
  });
}

}  // namespace cosplat

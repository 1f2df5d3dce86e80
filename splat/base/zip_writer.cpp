// What is written by libzip: archives, Npz::Write.

#include <zip.h>

#include <memory>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/base/zip_archive.h"

namespace cosplat {
namespace {

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;

// The member's bytes must outlive the archive, since libzip only reads them on closing.
void AddMember(zip_t* archive, const std::string& path, const ZipMember& member) {
  zip_source_t* source = zip_source_buffer(archive, member.bytes.data(), member.bytes.size(), 0);
  const zip_int64_t index = zip_file_add(archive, member.name.c_str(), source, ZIP_FL_ENC_UTF_8);
  if (index < 0) {
    zip_source_free(source);
    throw Error(path, member.name, std::string("cannot be written: ") + zip_strerror(archive));
  }
  constexpr time_t k1980 = 315619200;
  zip_file_set_mtime(archive, index, k1980, 0);
  if (!member.compressed) zip_set_file_compression(archive, index, ZIP_CM_STORE, 0);
}

}  // namespace

std::string ReasonOfZipError(int code) {
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

void WriteZip(const std::string& path, const std::vector<ZipMember>& members) {
  WriteViaTemporary(path, [&](const std::string& temporary) {
    int code = 0;
    Archive archive(zip_open(temporary.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code), zip_discard);
    if (!archive) throw Error(path, "cannot be written: " + ReasonOfZipError(code));
    for (const ZipMember& member : members) AddMember(archive.get(), path, member);
    if (zip_close(archive.get()) != 0)
      throw Error(path, std::string("write failed: ") + zip_strerror(archive.get()));
    archive.release();
  });
}

void Npz::Write(const std::string& path) const {
  std::vector<ZipMember> members;
  for (const auto& [name, array] : arrays_) members.push_back({name + ".npy", FormatNpy(array)});
  WriteZip(path, members);
}

}  // namespace cosplat

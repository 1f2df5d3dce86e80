// ZIP archives: .npz files, PyTorch's checkpoints, bundles of SOG. Members are read into memory and
// not to disk, so that a member's name is only a name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "splat/base/error.h"

struct zip;  // libzip's archive

namespace cosplat {

// What libzip says of an error code of zip_open.
std::string ReasonOfZipError(int code);

// Limit of all members together, uncompressed: far more than a model or a track has, so that a
// small file that inflates without end is refused before it is read.
constexpr uint64_t kMaxArchiveBytes = uint64_t(1) << 31;
inline Error TooMuchUnpacked(const std::string& path, const std::string& member) {
  return Error(path, member, "and the members before it have more than 2 GiB when unpacked");
}

class ZipReader {
 public:
  // Throws Error(path, "cannot be read as `kind`: ..."), or that there is more than
  // kMaxArchiveBytes in it.
  ZipReader(const std::string& path, const std::string& kind);
  // The same of an archive's bytes; `path` is for errors.
  ZipReader(const std::string& path, const std::string& kind, std::vector<char> bytes);

  size_t size() const;  // members
  // Empty if the name cannot be read.
  std::string Name(size_t index) const;
  // The index of the member with this name, or size().
  size_t Find(const std::string& name) const;
  // Throws Error naming file and member if the member is damaged or has more than `limit` bytes.
  std::vector<char> Read(size_t index, uint64_t limit = std::numeric_limits<uint64_t>::max()) const;

 private:
  struct Discard {
    void operator()(zip* archive) const;
  };
  void CheckTotal() const;

  std::string path_;
  std::vector<char> bytes_;  // that `archive_` reads, if not those of the file
  std::unique_ptr<zip, Discard> archive_;
};

struct ZipMember {
  std::string name;
  std::string bytes;
  bool compressed = true;  // deflated; false: stored, for what is compressed already
};

// In the order given, dated 1980, so that equal members give equal files. Atomic. Throws Error if
// the file cannot be written.
void WriteZip(const std::string& path, const std::vector<ZipMember>& members);

}  // namespace cosplat

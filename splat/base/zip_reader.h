// Reading the members of a ZIP archive into memory: .npz files, PyTorch's checkpoints. Nothing is
// written to disk, so that a member's name is only a name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

struct zip;  // libzip's archive

namespace cosplat {

// What libzip says of an error code of zip_open.
std::string ReasonOfZipError(int code);

class ZipReader {
 public:
  // Throws Error(path, "cannot be read as `kind`: ...").
  ZipReader(const std::string& path, const std::string& kind);

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
  std::string path_;
  std::unique_ptr<zip, Discard> archive_;
};

}  // namespace cosplat

// Compressed bytes in memory: gzip by zlib, Zstandard by libzstd. The sizes that a file states are
// the caller's to check: nothing here allocates more than it is asked for.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace cosplat {

// A gzip stream that is inflated as it is read.
class GunzipReader {
 public:
  // `path` names the file in errors; `bytes` must outlive the reader.
  GunzipReader(const std::string& path, const std::vector<char>& bytes);
  ~GunzipReader();
  // The next `size` inflated bytes. Throws Error naming `field` if the stream ends earlier or is
  // damaged.
  std::vector<unsigned char> Read(const std::string& field, size_t size);

 private:
  struct Stream;
  std::string path_;
  std::unique_ptr<Stream> stream_;
};

// At zlib's highest level. Without a time, so that equal bytes give equal files.
std::string Gzip(const std::string& bytes);

// One Zstandard frame, which must inflate to exactly `size` bytes. Throws Error naming path and
// field otherwise.
std::vector<unsigned char> Unzstd(const std::string& path,
                                  const std::string& field,
                                  const char* bytes,
                                  size_t count,
                                  size_t size);
std::string Zstd(const std::string& bytes);

}  // namespace cosplat

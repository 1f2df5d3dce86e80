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
  // As many of the next `size` bytes as there are. Throws Error if the stream is damaged or cut.
  std::vector<char> ReadUpTo(size_t size);

 private:
  // Returns the number of bytes before the end of the stream, or of its file (`cut`).
  size_t Inflate(const std::string& field, unsigned char* out, size_t size, bool& cut);
  struct Stream;
  std::string path_;
  std::unique_ptr<Stream> stream_;
};

// A whole file, inflated if gzip packed it. Throws Error if it is missing or damaged, or if it
// inflates to more than a hundred times its size: floats shrink to a half, zeros to a thousandth.
std::vector<char> ReadUnpacked(const std::string& path);
// Its first bytes, inflated likewise: `count`, or as many as can be had. Empty if there is no file.
std::string FirstBytes(const std::string& path, size_t count);

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

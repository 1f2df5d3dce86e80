#include <zstd.h>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr int kZstdLevel = 19;  // the highest that needs no more memory to inflate

}  // namespace

std::vector<unsigned char> Unzstd(const std::string& path,
                                  const std::string& field,
                                  const char* bytes,
                                  size_t count,
                                  size_t size) {
  std::vector<unsigned char> out(size);
  const size_t written = ZSTD_decompress(out.data(), out.size(), bytes, count);
  if (ZSTD_isError(written))
    throw Error(path, field, std::string("is damaged: ") + ZSTD_getErrorName(written));
  if (written != size) throw Error(path, field, Format("has {} bytes, expected {}", written, size));
  return out;
}

std::string Zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const size_t written =
      ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kZstdLevel);
  if (ZSTD_isError(written)) throw Error("zstd", ZSTD_getErrorName(written));
  out.resize(written);
  return out;
}

}  // namespace cosplat

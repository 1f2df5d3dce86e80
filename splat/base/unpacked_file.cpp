// Files that gzip may have packed: zlib's part is in compression.cpp, the browser's in
// zip_reader_stb.cpp.
#include <algorithm>
#include <fstream>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/skipped.h"

namespace cosplat {
namespace {

bool IsGzip(const std::vector<char>& bytes) {
  return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b';
}

}  // namespace

std::vector<char> ReadUnpacked(const std::string& path) {
  std::vector<char> bytes = ReadFile(path);
  if (!IsGzip(bytes)) return bytes;
  constexpr size_t kMaxPerByte = 100, kAlwaysAllowed = 1 << 24, kBlock = 1 << 20;
  const size_t limit = std::max(kMaxPerByte * bytes.size(), kAlwaysAllowed);
  GunzipReader reader(path, bytes);
  std::vector<char> unpacked;
  for (std::vector<char> block; !(block = reader.ReadUpTo(kBlock)).empty();) {
    unpacked.insert(unpacked.end(), block.begin(), block.end());
    if (unpacked.size() > limit)
      throw Error(path, "gzip", "inflates to more than " + std::to_string(limit) + " bytes");
  }
  return unpacked;
}

std::string FirstBytes(const std::string& path, size_t count) {
  std::vector<char> bytes(1 << 12);
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), std::streamsize(bytes.size()));
  bytes.resize(size_t(std::max<std::streamsize>(stream.gcount(), 0)));
  if (!IsGzip(bytes))
    return {bytes.begin(), bytes.begin() + ptrdiff_t(std::min(count, bytes.size()))};
  try {
    const std::vector<char> first = GunzipReader(path, bytes).ReadUpTo(count);
    return {first.begin(), first.end()};
  } catch (const Error&) {  // the browser's reader needs the whole file; or it is damaged
  }
  std::vector<char> whole = bytes;
  Problem([&] { whole = ReadUnpacked(path); });  // its reader says so
  return {whole.begin(), whole.begin() + ptrdiff_t(std::min(count, whole.size()))};
}

}  // namespace cosplat

#include "splat/base/crc32.h"

#include <zlib.h>

namespace cosplat {

uint32_t Crc32(const void* bytes, size_t size, uint32_t before) {
  if (size == 0) return before;  // zlib starts again at a null pointer
  return uint32_t(crc32_z(before, static_cast<const Bytef*>(bytes), size));
}

}  // namespace cosplat

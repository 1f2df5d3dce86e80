// CRC-32 (ISO 3309, as in zip and PNG): finds damage and changes that are not malicious.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cosplat {

// Of `size` bytes that follow those with checksum `before`.
uint32_t Crc32(const void* bytes, size_t size, uint32_t before = 0);

}  // namespace cosplat

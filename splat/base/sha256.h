// SHA-256 (FIPS 180-4), used to identify a model file without embedding it.
#pragma once

#include <cstddef>
#include <string>

namespace cosplat {

// Lower-case hexadecimal digest, 64 characters.
std::string Sha256(const void* bytes, size_t size);

}  // namespace cosplat

// What a training run holds, by name: Trainer::Memory adds up what its parts say of themselves.
#pragma once

#include <cstddef>
#include <string>

#include "splat/device/buffer.h"

namespace cosplat {

// What a part grows with; kFixed: with neither.
enum class MemoryOf { kGaussians, kPixels, kFixed };

struct MemoryPart {
  std::string name;
  size_t bytes = 0;  // by capacity: what was allocated, whether in use or not
  MemoryOf of = MemoryOf::kGaussians;
};

// Bytes that buffers or vectors hold.
template <class... Containers>
size_t HeldBy(const Containers&... containers) {
  return (size_t(0) + ... + (containers.capacity() * sizeof(*containers.data())));
}

}  // namespace cosplat

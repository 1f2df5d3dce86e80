// Structures of callers that were built with another version of cosplat.h.
//
// Both sides know the size of their structure. A smaller one than ours would come from an older
// header; there are none yet. A larger one may come from a newer header: the fields that this
// version does not know must be zero, which is every field's default.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "avatar/plugin/coded_error.h"

namespace cosplat::plugin {

// Far above any structure of any version: a larger size means that it was not initialised.
constexpr uint32_t kMaxStruct = 1024;

template <class T>
uint32_t CheckedStructSize(const T* theirs, const char* name) {
  if (!theirs) throw CodedError(COSPLAT_ERROR_ARGUMENT, name, "is NULL");
  uint32_t size = 0;
  std::memcpy(&size, theirs, sizeof(size));  // every structure begins with it
  if (size < sizeof(T) || size > kMaxStruct)
    throw CodedError(COSPLAT_ERROR_ARGUMENT,
                     std::string(name) + ".struct_size",
                     std::to_string(size) + ", expected " + std::to_string(sizeof(T)));
  return size;
}

template <class T>
T ReadStruct(const T* theirs, const char* name) {
  const uint32_t size = CheckedStructSize(theirs, name);
  const auto* bytes = reinterpret_cast<const unsigned char*>(theirs);
  if (std::any_of(bytes + sizeof(T), bytes + size, [](unsigned char b) { return b != 0; }))
    throw CodedError(
        COSPLAT_ERROR_ARGUMENT, name, "uses fields that this version of the library does not know");
  T ours;
  std::memcpy(&ours, theirs, sizeof(T));
  return ours;
}

// Copies `ours`, except for the size, which stays the caller's.
template <class T>
void WriteStruct(T ours, T* theirs, const char* name) {
  const uint32_t size = CheckedStructSize(theirs, name);
  ours.struct_size = size;
  auto* bytes = reinterpret_cast<unsigned char*>(theirs);
  std::memcpy(bytes, &ours, sizeof(T));
  std::fill(bytes + sizeof(T), bytes + size, static_cast<unsigned char>(0));
}

}  // namespace cosplat::plugin

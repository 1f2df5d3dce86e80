// Structures of callers that were built with another version of cosplat.h.
//
// Both sides know the size of their structure. A smaller one than ours may come from an older
// header: the fields that it lacks are zero, which is every field's default. A larger one may come
// from a newer header: the fields that this version does not know must be zero.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "avatar/plugin/coded_error.h"
#include "avatar/plugin/cosplat.h"
#include "splat/base/text.h"

namespace cosplat::plugin {

// Far above any structure of any version: a larger size means that it was not initialised.
constexpr uint32_t kMaxStruct = 1024;

// Size in the first version of cosplat.h that had the structure.
template <class T>
constexpr size_t kFirstSize = sizeof(T);
template <>
inline constexpr size_t kFirstSize<cosplat_open_options> = offsetof(cosplat_open_options, bust);
template <>
inline constexpr size_t kFirstSize<cosplat_info> = offsetof(cosplat_info, knows_filmed);
template <>
inline constexpr size_t kFirstSize<cosplat_health> = offsetof(cosplat_health, drive_packets);

template <class T>
uint32_t CheckedStructSize(const T* theirs, const char* name) {
  if (!theirs) Refuse(name, "is NULL");
  uint32_t size = 0;
  std::memcpy(&size, theirs, sizeof(size));  // every structure begins with it
  if (size < kFirstSize<T> || size > kMaxStruct)
    Refuse(std::string(name) + ".struct_size", Format("{}, expected {}", size, sizeof(T)));
  return size;
}

template <class T>
T ReadStruct(const T* theirs, const char* name) {
  const uint32_t size = CheckedStructSize(theirs, name);
  const auto* bytes = reinterpret_cast<const unsigned char*>(theirs);
  const size_t known = std::min(size_t(size), sizeof(T));
  if (std::any_of(bytes + known, bytes + size, [](unsigned char b) { return b != 0; }))
    Refuse(name, "uses fields that this version of the library does not know");
  T ours{};
  std::memcpy(&ours, theirs, known);
  return ours;
}

// Copies as much of `ours` as theirs has, except for the size, which stays the caller's; what only
// theirs has is zero.
template <class T>
void WriteStruct(T ours, T* theirs, const char* name) {
  const uint32_t size = CheckedStructSize(theirs, name);
  ours.struct_size = size;
  const size_t known = std::min(size_t(size), sizeof(T));
  auto* bytes = reinterpret_cast<unsigned char*>(theirs);
  std::memcpy(bytes, &ours, known);
  std::fill(bytes + known, bytes + size, static_cast<unsigned char>(0));
}

}  // namespace cosplat::plugin

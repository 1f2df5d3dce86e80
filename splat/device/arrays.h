// States that consist of arrays. Such a type lists them once, in
//
//   template <class Visit, class... Of>
//   static void ForEachArray(const Visit& visit, Of&... of);
//
// which calls visit(name, width, array of each `of`...) for every array; width: numbers per entry.
// Copies to and from a stream's memory, bytes and checkpoints follow from it.
#pragma once

#include <cstddef>
#include <string>

#include "splat/device/buffer.h"

namespace cosplat {

// Copies arrays of host memory, which must stay valid until the stream has been waited for.
template <class T>
void UploadArrays(const T& from, T& to, Stream& stream) {
  T::ForEachArray(
      [&](const std::string&, size_t, auto& array, const auto& of_host) {
        array.Upload(of_host, stream);
      },
      to,
      from);
}

// Copies arrays to host memory; their values are valid once the stream has been waited for.
template <class T>
void DownloadArrays(const T& from, T& to, Stream& stream) {
  T::ForEachArray(
      [&](const std::string&, size_t, const auto& array, auto& of_host) {
        array.Download(of_host, stream);
      },
      from,
      to);
}

// Allocated bytes, by capacity.
template <class T>
size_t AllocatedByArrays(const T& of) {
  size_t bytes = 0;
  T::ForEachArray(
      [&](const std::string&, size_t, const auto& array) { bytes += AllocatedBytes(array); }, of);
  return bytes;
}

}  // namespace cosplat

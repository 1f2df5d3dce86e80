// Sorting along a Morton (Z-order) curve: points that are close in space end up close in memory.
// Density control keeps the Gaussians in this order, so that Gaussians invisible in a view form
// long runs that are skipped and the Gaussians of a tile lie together. Source: Morton 1966; 21 bits
// per axis.
#pragma once

#include <cstdint>

#include "splat/device/sort.h"

namespace cosplat {

class MortonSort {
 public:
  // Indices of the points ([n, 3], in the stream's memory), sorted by Morton code within their
  // bounding box, ties by index. Non-finite points come last. Valid until the next call.
  View<const uint32_t> Order(View<const float> points, Stream& stream);
  size_t allocated_bytes() const {
    return order_.allocated_bytes() + AllocatedBytes(codes_, boxes_);
  }  // bytes

 private:
  KeyedValues order_;
  Buffer<uint64_t> codes_;
  Buffer<float> boxes_;  // [blocks, 6]
};

}  // namespace cosplat

// Order along a Morton (Z-order) curve: points near each other in space come near each other in
// memory. Density control keeps the Gaussians in it, so that what a view does not see is left out
// in long runs and what a tile draws lies together. Source: Morton 1966; 21 bits per axis.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/device/sort.h"

namespace cosplat {

class MortonSort {
 public:
  // Indices of the points ([n, 3], in the stream's memory) in that order within their bounding box;
  // equal codes by index. Points that are not finite come last. Until the next call.
  View<const uint32_t> Order(View<const float> points, Stream& stream);
  size_t held() const { return order_.held() + HeldBy(codes_, boxes_); }  // bytes

 private:
  KeyedValues order_;
  Buffer<uint64_t> codes_;
  Buffer<float> boxes_;  // [blocks, 6]
};

// The same on the host.
std::vector<uint32_t> MortonOrder(const std::vector<std::array<float, 3>>& points);

}  // namespace cosplat

// Order along a Morton (Z-order) curve: points near each other in space come near each other in
// memory. Density control keeps the Gaussians in it, so that what a view does not see is left out
// in long runs and what a tile draws lies together. Source: Morton 1966; 21 bits per axis.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace cosplat {

// Indices of the points in that order within their bounding box; equal codes by index. Points that
// are not finite come last.
std::vector<uint32_t> MortonOrder(const std::vector<std::array<float, 3>>& points);

}  // namespace cosplat

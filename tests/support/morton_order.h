// MortonSort's order of points on the host.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/train/density/morton.h"

namespace cosplat {

inline std::vector<uint32_t> MortonOrder(const std::vector<std::array<float, 3>>& points) {
  MortonSort sort;
  const View<const uint32_t> order =
      sort.Order({points.empty() ? nullptr : points[0].data(), 3 * points.size()}, HostStream());
  return {order.begin(), order.end()};
}

}  // namespace cosplat

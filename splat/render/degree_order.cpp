#include "splat/render/degree_order.h"

namespace cosplat {

std::vector<uint32_t> SortByDegree(Gaussians& g) {
  FindDegrees(g);
  std::vector<uint32_t> order;
  for (int degree = 0; degree <= g.degree; ++degree)
    for (size_t i = 0; i < g.degrees.size(); ++i)
      if (g.degrees[i] == degree) order.push_back(uint32_t(i));
  if (!order.empty()) g.Gather(order);
  return order;
}

}  // namespace cosplat

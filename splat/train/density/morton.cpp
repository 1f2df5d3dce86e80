#include "splat/train/density/morton.h"

#include "splat/device/for_each.h"
#include "splat/train/density/kernels/control.h"

namespace cosplat {

View<const uint32_t> MortonSort::Order(View<const float> points, Stream& stream) {
  const size_t n = points.count / 3;
  const size_t blocks = (n + FindBoxes::kBlock - 1) / FindBoxes::kBlock;
  boxes_.Refill(6 * blocks, stream);
  codes_.Refill(n, stream);
  order_.Refill(n, stream);
  if (n == 0) return {};
  ForEach(blocks, stream, FindBoxes{points, boxes_.view()});
  ForEach(1, stream, JoinBoxes{boxes_.view()});
  ForEach(n,
          stream,
          LowKeys{points,
                  std::as_const(boxes_).view(),
                  codes_.view(),
                  order_.keys.view(),
                  order_.values.view()});
  stream.Sort(order_, 32);
  ForEach(
      n,
      stream,
      HighKeys{
          std::as_const(codes_).view(), std::as_const(order_.values).view(), order_.keys.view()});
  stream.Sort(order_, 32);
  return std::as_const(order_.values).view();
}

}  // namespace cosplat

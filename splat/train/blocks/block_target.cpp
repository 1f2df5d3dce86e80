#include "splat/train/blocks/block_target.h"

#include <algorithm>
#include <array>

#include "splat/device/for_each.h"
#include "splat/math/photometric.h"
#include "splat/render/kernels/pixel_bytes.h"

namespace cosplat {
namespace {

using Rgba = std::array<float, 4>;  // colours multiplied by alpha

Rgba LayerAt(const Image8& layer, size_t i) {
  Rgba pixel{};
  if (layer.empty()) return pixel;
  for (size_t c = 0; c < 4; ++c) pixel[c] = math::FromByte(layer.data[4 * i + c]);
  return pixel;
}

Rgba PhotographAt(const Image8& image, size_t i) {
  const size_t n = size_t(image.channels);
  const uint8_t* p = &image.data[n * i];
  const float alpha = n == 4 ? math::FromByte(p[3]) : 1.0f;
  Rgba pixel{0, 0, 0, alpha};
  for (size_t c = 0; c < 3; ++c) pixel[c] = alpha * math::FromByte(p[n == 1 ? 0 : c]);
  return pixel;
}

Rgba Over(const Rgba& front, const Rgba& behind) {
  Rgba all;
  for (size_t c = 0; c < 4; ++c) all[c] = front[c] + (1 - front[3]) * behind[c];
  return all;
}

// Over black, as exact as straight alpha can say it.
Rgba Exposed(const Exposure& exposure, const Rgba& pixel) {
  const math::Vec3<float> shown =
      math::Exposed(exposure.data(), math::Vec3<float>{pixel[0], pixel[1], pixel[2]});
  return {shown.x, shown.y, shown.z, pixel[3]};
}

}  // namespace

Image8 TargetOfBlock(const Image8& photograph,
                     const FrameLayers& others,
                     const Image8& own,
                     const Image8& whole,
                     const Exposure& exposure) {
  Image8 target(photograph.width, photograph.height, 4);
  ParallelFor(target.pixels(), [&](size_t i) {
    const Rgba front = LayerAt(others.front, i), behind = LayerAt(others.behind, i);
    const Rgba block = LayerAt(own, i);
    const float of_others = front[3] + (1 - front[3]) * (1 - block[3]) * behind[3];
    const Rgba layers = Exposed(exposure, Over(front, Over(block, behind)));
    const Rgba finished = Exposed(exposure, LayerAt(whole, i));
    const Rgba photo = PhotographAt(photograph, i);
    Rgba mixed;
    for (size_t c = 0; c < 4; ++c)
      mixed[c] = layers[c] + (1 - of_others) * (photo[c] - finished[c]);
    const float alpha = std::min(mixed[3], 1.0f);
    uint8_t* p = &target.data[4 * i];
    for (size_t c = 0; c < 3; ++c) p[c] = alpha > 0 ? math::ToByte(mixed[c] / alpha) : 0;
    p[3] = math::ToByte(alpha);
  });
  return target;
}

}  // namespace cosplat

#include "splat/render/world_arrays.h"

namespace cosplat {
namespace {

// Uploads an array; returns null if the host has none.
template <class T>
const T* Copy(Buffer<T>& to, const T* from, size_t numbers, Stream& stream) {
  if (!from) return nullptr;
  to.Upload(from, numbers, stream);
  return to.data();
}

float* Prepared(Buffer<float>& to, const float* from, size_t numbers, bool copy, Stream& stream) {
  if (!from) {
    to.Refill(0, stream);
    return nullptr;
  }
  if (copy)
    to.Upload(from, numbers, stream);
  else
    to.Refill(numbers, stream);
  return to.data();
}

}  // namespace

WorldGaussians WorldArrays::Upload(const WorldGaussians& host, Stream& stream) {
  const size_t n = host.count;
  WorldGaussians g;
  g.count = n;
  g.rest_width = host.rest_width;
  g.position = Copy(position_, host.position, 3 * n, stream);
  g.rotation = Copy(rotation_, host.rotation, 4 * n, stream);
  g.scale_log = Copy(scale_log_, host.scale_log, 3 * n, stream);
  g.opacity_logit = Copy(opacity_logit_, host.opacity_logit, n, stream);
  g.color_dc = Copy(color_dc_, host.color_dc, 3 * n, stream);
  g.color_rest = Copy(color_rest_, host.color_rest, size_t(host.rest_width) * n, stream);
  g.color_frame = Copy(color_frame_, host.color_frame, 4 * n, stream);
  g.degree = Copy(degree_, host.degree, n, stream);
  g.smoothing = Copy(smoothing_, host.smoothing, n, stream);
  g.antialiased = host.antialiased;
  g.low_pass_variance = host.low_pass_variance;
  return g;
}

WorldGradients WorldGradientArrays::Prepare(const WorldGradients& host,
                                            size_t n,
                                            int rest_width,
                                            Stream& stream) {
  const bool copy = host.drawn_groups_only;
  const auto prepared = [&](Buffer<float>& to, const float* from, size_t width) {
    return Prepared(to, from, width * n, copy, stream);
  };
  WorldGradients d;
  d.drawn_groups_only = copy;
  d.position = prepared(position_, host.position, 3);
  d.rotation = prepared(rotation_, host.rotation, 4);
  d.scale_log = prepared(scale_log_, host.scale_log, 3);
  d.opacity_logit = prepared(opacity_logit_, host.opacity_logit, 1);
  d.color_dc = prepared(color_dc_, host.color_dc, 3);
  d.color_rest = prepared(color_rest_, host.color_rest, size_t(rest_width));
  d.color_frame = prepared(color_frame_, host.color_frame, 4);
  d.screen = prepared(screen_, host.screen, 2);
  return d;
}

void WorldGradientArrays::Download(const WorldGradients& host, Stream& stream) const {
  position_.Download(host.position, stream);
  rotation_.Download(host.rotation, stream);
  scale_log_.Download(host.scale_log, stream);
  opacity_logit_.Download(host.opacity_logit, stream);
  color_dc_.Download(host.color_dc, stream);
  color_rest_.Download(host.color_rest, stream);
  color_frame_.Download(host.color_frame, stream);
  screen_.Download(host.screen, stream);
}

}  // namespace cosplat

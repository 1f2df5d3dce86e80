#include "splat/io/color_weights.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "splat/base/error.h"
#include "splat/basis_constants.h"
#include "splat/math/dcsh.h"
#include "splat/media/image_glance.h"

namespace cosplat {
namespace {

// Depth of a point that the camera's image shows, or 0.
float DepthInImage(const Camera& camera, const float* p) {
  const Sighting at = Sight(camera, p);
  return at.inside ? at.in_camera[2] : 0;
}

}  // namespace

std::vector<float> SeenBands(const Gaussians& g, const std::vector<Camera>& cameras) {
  if (g.basis != Basis::kSh) throw Error("basis", "is " + ToString(g.basis) + ", expected sh");
  const size_t width = size_t(CoefficientCount(g.degree) - 1);
  std::vector<float> seen(width * g.size(), 0.f);
  std::vector<std::array<float, 3>> centers;
  for (const Camera& camera : cameras) centers.push_back(camera.Center());
  const float* constants = BasisConstants(Basis::kSh);
  std::array<float, size_t(CoefficientCount(kMaxTrainedDegree))> basis;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* p = g.at(kPosition, i);
    std::array<double, basis.size()> sum{};
    double weights = 0;
    for (size_t c = 0; c < cameras.size(); ++c) {
      const float depth = DepthInImage(cameras[c], p);
      if (depth == 0) continue;
      const double weight = 1 / (double(depth) * depth);
      const math::Vec3<float> d{p[0] - centers[c][0], p[1] - centers[c][1], p[2] - centers[c][2]};
      const float inverse = 1 / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
      math::EvaluateBasis<kMaxTrainedDegree>(
          math::Vec3<float>{d.x * inverse, d.y * inverse, d.z * inverse}, constants, basis.data());
      for (size_t k = 0; k < width; ++k) sum[k] += weight * basis[1 + k];
      weights += weight;
    }
    for (size_t k = 0; k < width && weights > 0; ++k) seen[width * i + k] = float(sum[k] / weights);
  }
  return seen;
}

void MoveErrorToDc(
    const float* bands, const float* stored, const float* seen, int degree, float* dc) {
  const float constant = BasisConstants(Basis::kSh)[0];
  for (int k = 0; k < CoefficientCount(degree) - 1; ++k)
    for (int channel = 0; channel < 3; ++channel)
      dc[channel] += (bands[3 * k + channel] - stored[3 * k + channel]) * seen[k] / constant;
}

std::vector<float> SizeSignificance(const Gaussians& g) {
  std::vector<float> significance;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* s = g.at(kScaleLog, i);
    const float opacity = 1 / (1 + std::exp(-*g.at(kOpacityLogit, i)));
    significance.push_back(opacity * std::exp((s[0] + s[1] + s[2]) / 3));
  }
  return significance;
}

std::vector<float> WeightsOf(View<const float> significance) {
  std::vector<float> finite;
  for (const float s : significance) finite.push_back(std::isfinite(s) ? s : 0);
  double sum = 0;
  for (const float s : finite) sum += s;
  const float min = sum > 0 ? float(1e-4 * sum / double(finite.size())) : 1;
  std::vector<float> weights;
  for (const float s : finite) weights.push_back(std::max(s, min));
  return weights;
}

}  // namespace cosplat

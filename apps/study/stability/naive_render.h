// A renderer without our guards, following released code or the papers' formulas, to show what goes
// wrong. Pixel by pixel on scalar floats; in harmless cases its images equal ours
// (tests/study/stability_test.cpp).
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/gaussians.h"
#include "splat/math/pinhole.h"
#include "splat/math/ssim.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// Where the Jacobian of the projection is evaluated.
enum class NaiveJacobian {
  kUnclamped,    // at the centre, wherever it is (Zwicker et al. 2002, eq. 29)
  kAboutMiddle,  // slopes clamped to 1.3 half-sizes of the image about its middle (3DGS)
};

// A Gaussian's centre and covariance in the image, px. The quaternion is divided by its norm and
// the covariance inverted without checks.
struct NaiveFootprint {
  float x = 0, y = 0, depth = 0, opacity = 0;
  math::Sym2<float> covariance{0, 0, 0}, conic{0, 0, 0};
  math::Vec3<float> color{0, 0, 0};

  float Radius() const;  // 3 standard deviations along the longer axis
};
NaiveFootprint NaiveFootprintOf(const Gaussians& gaussians,
                                size_t i,
                                const Camera& camera,
                                NaiveJacobian jacobian = NaiveJacobian::kUnclamped);

// Sorted by depth along the camera's axis.
std::vector<uint32_t> DepthOrder(const std::vector<NaiveFootprint>& footprints);

// Blends in the given order over black. The alpha limits and the early stop are written as in 3DGS,
// so that a NaN does not compare below the limit and is drawn.
Image DrawNaive(const std::vector<NaiveFootprint>& footprints,
                const std::vector<uint32_t>& order,
                int width,
                int height);

std::vector<NaiveFootprint> NaiveFootprints(const Gaussians& gaussians,
                                            const Camera& camera,
                                            NaiveJacobian jacobian = NaiveJacobian::kUnclamped);

// Structural similarity as written in the paper, in floats: variances as E[x^2] - E[x]^2 without
// clamping, and standard deviations as their square roots. Source: Wang et al. 2004, eq. 6, 9, 10,
// 14-16.
//
// For a window of values x[i] and y[i] with these weights (of sum 1).
inline float NaiveSsim(const float* weights, const float* x, const float* y, int count) {
  float mx = 0, my = 0, xx = 0, yy = 0, xy = 0;
  for (int i = 0; i < count; ++i) {
    mx += weights[i] * x[i];
    my += weights[i] * y[i];
    xx += weights[i] * x[i] * x[i];
    yy += weights[i] * y[i] * y[i];
    xy += weights[i] * x[i] * y[i];
  }
  const float sx = std::sqrt(xx - mx * mx), sy = std::sqrt(yy - my * my);
  const float covariance = xy - mx * my;
  const float luminance = (2 * mx * my + math::kSsimC1) / (mx * mx + my * my + math::kSsimC1);
  const float contrast = (2 * sx * sy + math::kSsimC2) / (sx * sx + sy * sy + math::kSsimC2);
  const float structure = (covariance + math::kSsimC2 / 2) / (sx * sy + math::kSsimC2 / 2);
  return luminance * contrast * structure;
}

}  // namespace cosplat

// A renderer without the guards of ours, as released code or the papers' formulas have it: for
// pictures of what then goes wrong. Pixel by pixel, on plain floats; where nothing goes wrong it
// draws what ours does (tests/study/stability_test.cpp).
#pragma once

#include <cstdint>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/gaussians.h"
#include "splat/math/pinhole.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// Where the Jacobian of the projection is taken.
enum class NaiveJacobian {
  kUnclamped,    // at the centre, wherever it is (Zwicker et al. 2002, eq. 29)
  kAboutMiddle,  // slopes clamped to 1.3 half-sizes of the image about its middle (3DGS)
};

// A Gaussian's centre and covariance in the image, px. The quaternion is divided by its norm and
// the covariance inverted whatever they are.
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

// By depth along the camera's axis.
std::vector<uint32_t> DepthOrder(const std::vector<NaiveFootprint>& footprints);

// In this order, over black: alpha's two limits and the stop are 3DGS's, written as there, so that
// a NaN is not below the limit and is drawn.
Image DrawNaive(const std::vector<NaiveFootprint>& footprints,
                const std::vector<uint32_t>& order,
                int width,
                int height);

std::vector<NaiveFootprint> NaiveFootprints(const Gaussians& gaussians,
                                            const Camera& camera,
                                            NaiveJacobian jacobian = NaiveJacobian::kUnclamped);

}  // namespace cosplat

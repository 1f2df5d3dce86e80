// Non-owning arrays of Gaussians in the world frame, and of their gradients, as passed to kernels.
#pragma once

#include <cstddef>
#include <cstdint>

#include "splat/config.h"

namespace cosplat {

// Gaussians are processed in groups that start at multiples of this, the number of lanes of the
// widest SIMD register.
constexpr size_t kGaussianGroup = 16;

struct WorldGaussians {
  size_t count = 0;
  int rest_width = 0;                    // floats per Gaussian in color_rest
  const float* position = nullptr;       // [count, 3] world units
  const float* rotation = nullptr;       // [count, 4] wxyz, any norm
  const float* scale_log = nullptr;      // [count, 3] log(world units)
  const float* opacity_logit = nullptr;  // [count] inverse logistic
  const float* color_dc = nullptr;       // [count, 3]
  const float* color_rest = nullptr;     // [count, rest_width]
  const float* color_frame = nullptr;    // [count, 4] wxyz: colour along R(frame)^T d; or null
  const uint8_t* degree = nullptr;       // [count] highest band of each; null: all are evaluated
  const float* smoothing = nullptr;      // [count] see Gaussians; null: none
  bool antialiased = false;              // see Gaussians
  float low_pass_variance = kAntialiasedBlurVariance;  // px^2, only if antialiased
};

struct WorldGradients {
  float* position = nullptr;
  float* rotation = nullptr;
  float* scale_log = nullptr;
  float* opacity_logit = nullptr;
  float* color_dc = nullptr;
  float* color_rest = nullptr;
  float* color_frame = nullptr;  // null when there is no color_frame
  float* screen = nullptr;       // [count, 2] dL/d(centre in the image), per px

  // Leave the gradients of groups without a visible Gaussian unchanged instead of zeroing them.
  bool drawn_groups_only = false;
};

// The camera and the other constants of a view, as plain numbers.
struct ViewParameters {
  float rotation[9];  // cam_from_world, row-major
  float translation[3];
  float center[3];  // camera centre in the world
  float fx, fy, cx, cy, width, height;
  float near_plane;              // smallest depth that is drawn
  const float* basis_constants;  // splat/basis_constants.h
  bool folds_direction;          // whether Fold (splat/math/dcsh.h) precedes the basis
  int degree;                    // highest band evaluated, <= the stored one
};

}  // namespace cosplat

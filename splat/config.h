// Constants of the renderer, each with its source.
#pragma once

namespace cosplat {

// Side of a tile, px (Kerbl et al. 2023).
constexpr int kTileSize = 16;

// Side of the pixel blocks in the CPU's blend loop, px: a block has as many pixels as the widest
// SIMD register has lanes.
constexpr int kBlockSize = 4;
// The CPU's blend loop checks for opaque blocks after every this many splats.
constexpr int kStopInterval = 16;

// Contributions below one grey level of 255 are dropped (3DGS).
constexpr float kMinAlpha = 1.0f / 255.0f;

// Alpha is capped so that 1 / (1 - alpha) stays bounded in the backward pass (3DGS).
constexpr float kMaxAlpha = 0.99f;

// A pixel accepts splats while its transmittance is at least this. The splat that brings it below
// is the last and is included, so that forward and backward stop at the same one (3DGS drops it).
constexpr float kMinTransmittance = 1e-4f;

// Degrees of the polynomial that approximates exp() in the CPU's blend loop. The default has full
// float precision; docs/performance.md has the cost and gain of lower degrees.
constexpr int kMinExpDegree = 2;
constexpr int kMaxExpDegree = 5;

// Low-pass filter added to the projected covariance, px^2 (3DGS).
constexpr float kBlurVariance = 0.3f;

// The same of anti-aliased Gaussians, near the variance of a pixel's box, 1/12 px^2; and the least
// ratio of determinants that their opacity follows (both: Mip-Splatting's released code).
constexpr float kAntialiasedBlurVariance = 0.1f;
constexpr float kMinLowPassRatio = 2.5e-5f;

// Variance of the 3D smoothing filter, squared sampling intervals (Mip-Splatting).
constexpr float kSmoothingVariance = 0.2f;

// Slopes x/z, y/z are clamped to the image plus this fraction of its size on each side. 3DGS clamps
// to 1.3 half-sizes about the image's centre; here it is about the principal point, as in gsplat.
constexpr float kJacobianMargin = 0.15f;

// Gaussians whose 2D covariance has a smaller determinant, px^4, are not rendered.
constexpr float kMinDeterminant = 1e-6f;

// Gaussians whose quaternion has a smaller squared norm are not rendered: it has no direction.
constexpr float kMinQuaternionNorm2 = 1e-8f;

}  // namespace cosplat

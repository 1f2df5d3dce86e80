// Constants of the renderer, each with its source.
#pragma once

namespace cosplat {

// Side of a tile, px (Kerbl et al. 2023).
constexpr int kTileSize = 16;

// Side of the blocks that the CPU's blend loop works on, px: as many pixels as the widest SIMD
// register has lanes.
constexpr int kBlockSize = 4;
// It looks which blocks are opaque after this many splats.
constexpr int kStopInterval = 16;

// Contributions below one grey level of 255 are dropped (3DGS).
constexpr float kMinAlpha = 1.0f / 255.0f;

// Alpha is capped so that 1 / (1 - alpha) stays bounded in the backward pass (3DGS).
constexpr float kMaxAlpha = 0.99f;

// A pixel takes splats while its transmittance is at least this; the splat that brings it below is
// the last and is included, so that forward and backward stop at the same one (3DGS drops it).
constexpr float kMinTransmittance = 1e-4f;

// Degrees of the polynomial for the exponential in the CPU's blend loop. The default is exact to a
// float's precision; what less costs and gains: docs/performance.md.
constexpr int kMinExpDegree = 2;
constexpr int kMaxExpDegree = 5;

// Low-pass filter added to the projected covariance, px^2 (3DGS).
constexpr float kBlurVariance = 0.3f;

// Slopes x/z, y/z are clamped to the image plus this share of its size on each side. 3DGS clamps
// to 1.3 half-sizes about the image's middle; here it is about the principal point, as in gsplat.
constexpr float kJacobianMargin = 0.15f;

// A 2D covariance with a smaller determinant, px^4, is not drawn.
constexpr float kMinDeterminant = 1e-6f;

// A rotation with a smaller squared norm is not drawn: it has no direction.
constexpr float kMinQuaternionNorm2 = 1e-8f;

// Nearest depth drawn, scene units (gsplat; 3DGS has 0.2, too far for a head in metres).
constexpr float kNearPlane = 0.01f;

}  // namespace cosplat

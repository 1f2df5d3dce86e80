// Time per pixel-splat pair of the blend loop at maximum density: one 16x16 tile under 128 splats
// that cover every pixel without making any opaque, that is 32,768 pairs and no early stop. One
// thread.
#pragma once

namespace cosplat {

// Floating-point operations per pair, a fused multiply-add counting as two; the basis for the share
// of the FMA peak. Forward: exponent 5, exponential 14, alpha and blending 6. Backward: the same
// again plus the derivatives.
constexpr double kBlendForwardFlops = 25;
constexpr double kBlendBackwardFlops = 60;

struct BlendTimes {
  double forward_ns = 0;   // per pixel-splat pair
  double backward_ns = 0;  // likewise
  double checksum = 0;     // of the results; equal on every instruction set
};

// The blend loop on the instruction set in use; the fastest of `batches`.
BlendTimes MeasureBlend(int batches);

// The same formulas on scalar floats, one pixel at a time.
BlendTimes MeasureScalarBlend(int batches);

}  // namespace cosplat

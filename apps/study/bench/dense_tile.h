// Time per pixel and splat of the blend loop at its densest: one 16x16 tile under 128 splats that
// cover every pixel, none opaque at the end: 32,768 pairs and no early stop. One thread.
#pragma once

namespace cosplat {

// Floating-point operations per pair that the loops need, a fused multiply-add counting as two:
// what the share of the FMA peak is reckoned with. Exponent 5, exponential 14, alpha and blending 6
// forward; backward does that again and the derivatives of it.
constexpr double kBlendForwardFlops = 25;
constexpr double kBlendBackwardFlops = 60;

struct BlendTimes {
  double forward_ns = 0;   // per pixel and splat
  double backward_ns = 0;  // likewise
  double checksum = 0;     // of what was computed: alike on every instruction set
};

// The blend loop on the instruction set in use; the fastest of `batches`.
BlendTimes MeasureBlend(int batches);

// The same formulas on plain floats, a pixel at a time.
BlendTimes MeasureScalarBlend(int batches);

}  // namespace cosplat

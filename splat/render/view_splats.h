// Gaussians as other splat renderers take them, for one view: colours instead of coefficients, and
// the blur of training inside the scales.
//
// WorldGaussians + Camera -> FillViewSplats -> ViewSplats -> the browser's splat renderer
// (apps/web/src/playcanvas.js). On the CPU.
//
// 3DGS adds 0.3 px^2 to both variances of a splat's footprint (kBlurVariance), for which opacities
// are trained. A renderer that adds less is given the rest as an isotropic widening of the
// Gaussian, exact on the optical axis; beside it, by the angle t, the widened footprint is up to 1
// / cos^2 t longer towards the edge of the image.
#pragma once

#include "splat/base/camera.h"
#include "splat/basis.h"
#include "splat/device/buffer.h"
#include "splat/device/sort.h"
#include "splat/render/kernels/world_gaussians.h"

namespace cosplat {

// In the order of depth, the nearest first, so that the order of one frame's splats is also that of
// the next one's: renderers that sort beside drawing show a frame in an earlier one's order. A
// Gaussian that cannot be seen, or that is not finite, comes last and has opacity 0.
struct ViewSplats {
  Buffer<float> centers;    // [N, 4] x, y, z, world units; 0
  Buffer<float> colors;     // [N, 4] red, green, blue, sRGB, not clamped above; opacity
  Buffer<float> scales;     // [N, 4] standard deviations along the rotated axes, world units; 0
  Buffer<float> rotations;  // [N, 4] wxyz, unit

  Buffer<float> unsorted[4];  // the same in the order of the Gaussians
  Buffer<float> depths;       // [N]
  KeyedValues order;
};

// degree: highest band evaluated, at most the stored one. blur_variance: px^2, what the other
// renderer lacks of kBlurVariance. Throws Error as Rasterizer::Forward, and if the Gaussians are
// anti-aliased, whose opacities depend on their footprints. Bit-identical for any number of
// threads.
void FillViewSplats(const WorldGaussians& gaussians,
                    Basis basis,
                    const Camera& camera,
                    int degree,
                    float blur_variance,
                    ViewSplats& out);

}  // namespace cosplat

// Small scenes and views for the stability suite.
#pragma once

#include <cstddef>

#include "splat/base/camera.h"
#include "splat/gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// At the origin, looking along +z; the focal length equals the image side.
Camera StraightCamera(int side);

// Rotated by `rad` about its own centre, to the right.
Camera Turned(const Camera& camera, double rad);

// `count` blobs of degree 1 in random colours, of about the size `scale`, at positions distributed
// normally around (0, 0, depth) with standard deviation 0.3.
Gaussians RandomBlobs(size_t count, float depth, uint64_t seed, float scale = 0.1f);

// Appends an isotropic Gaussian.
struct Blob {
  float position[3], scale, opacity, color[3];  // world units; colour as seen
};
void Append(const Blob& blob, Gaussians& gaussians);

// Renders with the product's renderer, over black.
RenderedImage Draw(const Gaussians& gaussians, const Camera& camera);

// Weight of value i of an image [3, height, width] in the loss below; the weights vary.
float PixelWeight(size_t i);

// The image and the gradients of WeighedSum of its values.
struct DrawnBothWays {
  RenderedImage image;
  Gaussians gradients;
};
DrawnBothWays DrawBothWays(const Gaussians& gaussians, const Camera& camera);

// The loss that DrawBothWays differentiates.
double WeighedSum(const RenderedImage& image);

// Number of non-finite gradients.
size_t CountNotFinite(const Gaussians& gradients);

}  // namespace cosplat

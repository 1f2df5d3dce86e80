// Small scenes and views for the stability suite.
#pragma once

#include <cstddef>

#include "splat/base/camera.h"
#include "splat/gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// At the origin, looking along +z; focal length of the image's side.
Camera StraightCamera(int side);

// Turned by `rad` about its own centre, to the right.
Camera Turned(const Camera& camera, double rad);

// `count` blobs of degree 1 in random colours, of about this standard deviation, 0.3 around
// (0, 0, depth).
Gaussians RandomBlobs(size_t count, float depth, uint64_t seed, float scale = 0.1f);

// Adds a round one.
struct Blob {
  float position[3], scale, opacity, color[3];  // world units; colour as it is seen
};
void Append(const Blob& blob, Gaussians& gaussians);

// What the product draws, over black.
RenderedImage Draw(const Gaussians& gaussians, const Camera& camera);

// Of number i of an image [3, height, width] in the loss below: not all alike.
float PixelWeight(size_t i);

// And its gradients of the weighed sum of all its numbers.
struct DrawnBothWays {
  RenderedImage image;
  Gaussians gradients;
};
DrawnBothWays DrawBothWays(const Gaussians& gaussians, const Camera& camera);

// The loss that DrawBothWays derives.
double WeighedSum(const RenderedImage& image);

// How many numbers of the gradients are not finite.
size_t CountNotFinite(const Gaussians& gradients);

}  // namespace cosplat

// The cases that every back end must agree on, each with how far it may be off.
#pragma once

#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat::test {

// How far a device may be from the CPU. They round differently (exponential, order of operations),
// so that where a splat's alpha is at the floor of 1/255, or a pixel's transmittance at its
// cut-off, one draws what the other does not: such pixels are few, and off by no more than that
// alpha.
struct ParityTolerance {
  float pixel = 2e-5f;      // of a value in [0, 1], where nothing flipped
  double flipped = 0.005;   // share of values that may be further off
  float flip = 1.2f / 255;  // by no more than this times the largest colour
  double cosine = 1e-6;     // 1 - cosine of an attribute's gradients
  double relative = 2e-3;   // relative L2 of them
};

struct ParityCase {
  std::string name;
  Gaussians gaussians;
  Camera camera;
  RenderSettings settings;
  std::vector<float> color_frame;  // [N, 4] or empty
  ParityTolerance tolerance;
};

// Small: each takes the emulated device well below a second.
std::vector<ParityCase> ParityCases();

// A view with `count` Gaussians, as cases have it.
ParityCase RandomCase(
    const std::string& name, size_t count, int width, int height, Basis basis, int degree);

WorldGaussians ViewOf(const ParityCase& c);

}  // namespace cosplat::test

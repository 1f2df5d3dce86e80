#include "tests/parity/parity_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/base/rng.h"
#include "tests/support/looking_at.h"
#include "tests/support/random_gaussians.h"

namespace cosplat::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

void Scale(Gaussians& g, size_t i, float x, float y, float z) {
  const float s[3] = {std::log(x), std::log(y), std::log(z)};
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = s[k];
}

// Every way in which a Gaussian can be no Gaussian, among others that are.
ParityCase Degenerate() {
  ParityCase c = RandomCase("degenerate", 160, 40, 24, Basis::kDcsh, 2);
  Gaussians& g = c.gaussians;
  const float bad[] = {kNan, kInf, -kInf, 1e30f, -1e30f};
  size_t i = 0;
  for (const Attribute a : {kPosition, kRotation, kScaleLog, kOpacityLogit, kColorDc, kColorRest})
    for (const float value : bad) {
      if (a >= kColorDc && std::isfinite(value)) continue;  // a colour, if not one to compare by
      g.at(a, 3 * i++)[0] = value;
    }
  for (int k = 0; k < 4; ++k) g.at(kRotation, 1)[k] = 0;
  Scale(g, 4, 1e-20f, 1e-20f, 1e-20f);
  Scale(g, 7, 1e4f, 1e4f, 1e4f);
  const std::array<float, 3> eye = c.camera.Center();
  for (int k = 0; k < 3; ++k) g.at(kPosition, 10)[k] = eye[k];  // at the camera
  return c;
}

// Many splats of one place and depth, opaque: ties, and the cut-off of transmittance.
ParityCase OpaqueStack() {
  ParityCase c = RandomCase("opaque stack", 90, 33, 17, Basis::kSh, 1);
  Gaussians& g = c.gaussians;
  for (size_t i = 0; i < g.size(); ++i) {
    *g.at(kOpacityLogit, i) = 30;  // opacity 1
    for (int k = 0; k < 3; ++k) g.at(kPosition, i)[k] = g.at(kPosition, i % 3)[k];
    Scale(g, i, 0.2f, 0.15f, 0.1f);
  }
  return c;
}

ParityCase Shaped(const std::string& name, float x, float y, float z) {
  ParityCase c = RandomCase(name, 40, 64, 48, Basis::kDcsh, 1);
  for (size_t i = 0; i < c.gaussians.size(); ++i) Scale(c.gaussians, i, x, y, z);
  return c;
}

// Behind the camera, beside the image, transparent.
ParityCase NothingDrawn() {
  ParityCase c = RandomCase("nothing drawn", 70, 20, 20, Basis::kDcsh, 0);
  Gaussians& g = c.gaussians;
  for (size_t i = 0; i < g.size(); ++i) *g.at(kOpacityLogit, i) = -20;
  return c;
}

ParityCase Behind() {
  ParityCase c = RandomCase("half of it behind the camera", 120, 32, 32, Basis::kDcsh, 1);
  c.camera = LookingAt({0, 0, 0.2f}, {0, 0, 3}, 32);
  // What is near the camera is large: more values lie where alpha is at its floor.
  c.tolerance.relative = 1e-2;
  c.tolerance.cosine = 5e-5;
  return c;
}

ParityCase Antialiased() {
  ParityCase c = RandomCase("anti-aliased", 140, 48, 31, Basis::kDcsh, 1);
  Rng rng{7};
  c.gaussians.antialiased = true;
  for (size_t i = 0; i < c.gaussians.size(); ++i)
    c.gaussians.smoothing.push_back(0.02f * rng.Uniform());
  return c;
}

ParityCase OwnDegreesAndFrames() {
  ParityCase c = RandomCase("own degrees and frames", 130, 48, 31, Basis::kDcshLiteral, 3);
  Rng rng{5};
  c.gaussians.degrees.resize(c.gaussians.size());
  for (size_t i = 0; i < c.gaussians.size(); ++i) {
    const int own = c.gaussians.degrees[i] = uint8_t(rng.Below(4));
    float* rest = c.gaussians.at(kColorRest, i);
    std::fill(rest + 3 * (CoefficientCount(own) - 1), rest + c.gaussians.width(kColorRest), 0.0f);
  }
  c.color_frame.resize(4 * c.gaussians.size());
  for (float& q : c.color_frame) q = rng.Normal();
  return c;
}

}  // namespace

ParityCase RandomCase(
    const std::string& name, size_t count, int width, int height, Basis basis, int degree) {
  ParityCase c;
  c.name = name;
  c.gaussians = RandomGaussians(count, degree, basis, count + size_t(width));
  c.camera = Ring(3, 2.5f, 48)[1].Resized(width, height);
  c.settings = {{0.3f, 0.5f, 0.7f}, degree};
  return c;
}

std::vector<ParityCase> ParityCases() {
  std::vector<ParityCase> cases;
  for (int degree = 0; degree <= kMaxTrainedDegree; ++degree)
    cases.push_back(RandomCase("degree " + std::to_string(degree),
                               200,
                               50,
                               35,
                               Basis(degree % int(kBasisNames.size())),
                               degree));
  cases.push_back(RandomCase("no Gaussian", 0, 20, 20, Basis::kDcsh, 1));
  cases.push_back(RandomCase("one Gaussian", 1, 16, 16, Basis::kDcsh, 3));
  cases.push_back(RandomCase("one pixel", 60, 1, 1, Basis::kDcsh, 1));
  cases.push_back(RandomCase("one row", 60, 70, 1, Basis::kSh, 0));
  cases.push_back(RandomCase("whole tiles", 33, 32, 16, Basis::kDcsh, 1));
  cases.push_back(RandomCase("deep tiles", 700, 16, 16, Basis::kDcsh, 0));
  cases.push_back(Degenerate());
  cases.push_back(OpaqueStack());
  cases.push_back(Shaped("needles", 1, 0.01f, 0.01f));
  // A footprint a hundred times as long as wide: the terms of its exponent cancel to a
  // ten-thousandth of their size, and rounding grows by as much.
  cases.back().tolerance = {5e-4f, 0.02, 1.2f / 255, 1e-3, 5e-2};
  cases.push_back(Shaped("giants", 3, 2, 2.5f));
  cases.push_back(NothingDrawn());
  cases.push_back(Behind());
  cases.push_back(OwnDegreesAndFrames());
  cases.push_back(Antialiased());
  cases.push_back(RandomCase("fewer bands than stored", 100, 30, 30, Basis::kDcsh, 3));
  cases.back().settings.degree = 1;
  return cases;
}

WorldGaussians ViewOf(const ParityCase& c) {
  WorldGaussians view = cosplat::ViewOf(c.gaussians);
  if (!c.color_frame.empty()) view.color_frame = c.color_frame.data();
  return view;
}

}  // namespace cosplat::test

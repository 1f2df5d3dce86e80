// apps/viewer/orbit_camera.h and framing.h: where the viewer looks from.
#include "apps/viewer/orbit_camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat/base/rng.h"
#include "tests/support/expect_error.h"
#include "tests/support/looking_at.h"
#include "tests/viewer/viewer_fixture.h"

namespace cosplat::test {
namespace {

using viewer::OrbitCamera;
using viewer::StartView;

std::array<float, 3> InCamera(const Camera& c, const Point& p) {
  std::array<float, 3> out = c.translation;
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) out[i] += c.rotation[3 * i + k] * p[k];
  return out;
}
std::array<float, 2> PixelOf(const Camera& c, const Point& p) {
  const auto q = InCamera(c, p);
  return {c.fx * q[0] / q[2] + c.cx, c.fy * q[1] / q[2] + c.cy};
}

// Off the middle in every way.
StartView Askew() {
  StartView start;
  start.camera = LookingAt({1, 0.6f, -2}, {0.1f, 0.2f, 0.3f}, 64);
  start.camera.width = 80;
  start.camera.cx += 3;
  start.camera.fy *= 1.1f;
  start.center = {0.2f, 0.1f, 0.4f};
  start.up = Unit({0.1f, -1, 0.05f});
  return start;
}
float AskewDepth() { return InCamera(Askew().camera, Askew().center)[2]; }

void ExpectNear(const Camera& a, const Camera& b, float tolerance) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_NEAR(a.fx, b.fx, 1e-3);
  EXPECT_NEAR(a.fy, b.fy, 1e-3);
  EXPECT_NEAR(a.cx, b.cx, 1e-3);
  EXPECT_NEAR(a.cy, b.cy, 1e-3);
  for (size_t i = 0; i < 9; ++i) EXPECT_NEAR(a.rotation[i], b.rotation[i], tolerance);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(a.translation[i], b.translation[i], tolerance);
}

TEST(OrbitCamera, BeginsAtItsCamera) {
  const StartView start = Askew();
  ExpectNear(OrbitCamera(start).At(80, 64), start.camera, 1e-6f);
}

TEST(OrbitCamera, AnotherShapeShowsTheWholeImage) {
  const StartView start = Askew();
  const Point corner{-0.4f, 0.9f, 0.2f};
  const auto before = PixelOf(start.camera, corner);
  const auto after = PixelOf(OrbitCamera(start).At(320, 128), corner);
  EXPECT_NEAR(after[0] - 160, 2 * (before[0] - 40), 1e-3);
  EXPECT_NEAR(after[1] - 64, 2 * (before[1] - 32), 1e-3);
}

TEST(OrbitCamera, CirclesItsTargetWhereItIsInTheImage) {
  const StartView start = Askew();
  OrbitCamera camera(start);
  Rng rng{3};
  for (int i = 0; i < 1000; ++i) camera.Orbit(0.4f * rng.Normal(), 0.2f * rng.Normal());
  const Camera moved = camera.At(80, 64);
  const auto q = InCamera(moved, start.center), at_first = InCamera(start.camera, start.center);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(q[i], at_first[i], 1e-4);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      float dot = 0;
      for (int c = 0; c < 3; ++c) dot += moved.rotation[3 * i + c] * moved.rotation[3 * k + c];
      EXPECT_NEAR(dot, i == k, 1e-5);
    }
}

TEST(OrbitCamera, CirclesAPointOnItsAxisWhereItsTargetIsNotInTheImage) {
  StartView start = Askew();
  const Point eye = start.camera.Center();
  for (size_t i = 0; i < 3; ++i)
    start.center[i] = eye[i] + start.camera.rotation[6 + i] + 2 * start.camera.rotation[i];
  OrbitCamera camera(start);
  camera.Orbit(1, 0.3f);
  Point on_axis{};
  for (size_t i = 0; i < 3; ++i) on_axis[i] = eye[i] + start.camera.rotation[6 + i];
  const auto q = InCamera(camera.At(80, 64), on_axis);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(q[i], i == 2, 1e-4);
}

TEST(OrbitCamera, GoesToItsRightAndUpAndStopsAtThePoles) {
  const StartView start = Askew();
  OrbitCamera right(start);
  right.Orbit(0.1f, 0);
  EXPECT_GT(InCamera(start.camera, right.At(80, 64).Center())[0], 0.1f);
  OrbitCamera up(start);
  up.Orbit(0, 0.1f);
  EXPECT_LT(InCamera(start.camera, up.At(80, 64).Center())[1], -0.1f);
  up.Orbit(0, 10);
  const Camera top = up.At(80, 64);
  const float down =
      top.rotation[6] * start.up[0] + top.rotation[7] * start.up[1] + top.rotation[8] * start.up[2];
  EXPECT_NEAR(down, -std::sin(1.5f), 1e-4);
}

TEST(OrbitCamera, PansBySharesOfTheImage) {
  const StartView start = Askew();
  const Point target = start.center;
  OrbitCamera camera(start);
  camera.Pan(0.25f, -0.125f);
  const auto before = PixelOf(start.camera, target), after = PixelOf(camera.At(80, 64), target);
  EXPECT_NEAR(after[1] - before[1], -0.125f * 64, 1e-2);
  EXPECT_NEAR(after[0] - before[0], 0.25f * 64 * start.camera.fx / start.camera.fy, 1e-2);
}

TEST(OrbitCamera, ZoomsWithinLimitsAndResets) {
  const StartView start = Askew();
  const Point target = start.center;
  OrbitCamera camera(start);
  camera.Zoom(1);
  EXPECT_NEAR(InCamera(camera.At(80, 64), target)[2], 0.9f * AskewDepth(), 1e-4);
  camera.Zoom(1e6f);
  EXPECT_GT(InCamera(camera.At(80, 64), target)[2], 0);
  camera.Zoom(-1e6f);
  EXPECT_LT(InCamera(camera.At(80, 64), target)[2], 21 * AskewDepth());
  camera.Orbit(1, 1);
  camera.Reset();
  ExpectNear(camera.At(80, 64), start.camera, 1e-6f);
}

TEST(Framing, TheWholeHeadFromTheFront) {
  const viewer::Content& head = PaintedHead();
  const Camera camera = head.start.camera;
  const std::vector<float>& v = head.avatar->model.mesh.vertices;
  for (size_t i = 0; i < v.size(); i += 3) {
    const auto p = PixelOf(camera, {v[i], v[i + 1], v[i + 2]});
    EXPECT_GT(p[0], 0);
    EXPECT_LT(p[0], camera.width);
    EXPECT_GT(p[1], 0);
    EXPECT_LT(p[1], camera.height);
  }
  EXPECT_NEAR(camera.rotation[8], -1, 1e-5);  // against the face, which looks along +z
  EXPECT_NEAR(camera.rotation[4], -1, 1e-5);  // y is up
}

TEST(Framing, StraysDoNotMatter) {
  Gaussians g = RandomGaussians(400, 0, Basis::kSh, 5);
  for (size_t i = 0; i < g.size(); ++i) *g.at(kOpacityLogit, i) = 2;
  for (size_t i = 0; i < 6; ++i) g.at(kPosition, i)[i % 3] = 1e4f * float(i + 1);
  g.at(kPosition, 7)[0] = NAN;
  *g.at(kOpacityLogit, 8) = -30;  // not to be seen
  g.at(kPosition, 8)[1] = 1e6f;
  const Camera camera = viewer::BeforeSplats("a.ply", g).camera;
  int inside = 0, far_out = 0;
  for (size_t i = 9; i < g.size(); ++i) {
    const float* p = g.at(kPosition, i);
    const auto pixel = PixelOf(camera, {p[0], p[1], p[2]});
    const float out = std::max(std::abs(pixel[0] - camera.cx), std::abs(pixel[1] - camera.cy));
    inside += out < camera.cx;
    far_out += out > 0.3f * camera.cx;
  }
  EXPECT_GT(inside, 385);
  EXPECT_GT(far_out, 80);
}

TEST(Framing, NothingToSeeIsAnError) {
  Gaussians g = RandomGaussians(3, 0, Basis::kSh, 5);
  for (size_t i = 0; i < g.size(); ++i) *g.at(kOpacityLogit, i) = -30;
  ExpectError([&] { viewer::BeforeSplats("a.ply", g); }, {"a.ply", "no splat is visible"});
}

TEST(Framing, AtTheFirstCameraLookingWhereAllLook) {
  const std::vector<Camera> ring = Ring(8, 3);
  const StartView start = viewer::AtCamera(ring);
  EXPECT_EQ(start.camera.rotation, ring[0].rotation);
  for (const float x : start.center) EXPECT_NEAR(x, 0, 1e-3);
  EXPECT_LT(start.up[1], -0.9f);
}

}  // namespace
}  // namespace cosplat::test

// flame/posing.h and flame/kernels/pose.h: what is left of a frame gives the bits of
// FlamePoser::Forward, and what would leave float's range is known before.
#include "flame/posing.h"

#include <gtest/gtest.h>

#include <limits>

#include "flame/kernels/pose.h"
#include "flame/pose.h"
#include "tests/flame/random_model.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

using Poser = FlamePoser<float>;

Poser::Parameters FrameOf(std::vector<float> expression) {
  Poser::Parameters frame;
  frame.expression = std::move(expression);
  for (int j = 0; j < kFlameJoints; ++j) frame.pose[j] = {0.1f * float(j), 0.3f, -0.2f};
  frame.translation = {1, 2, 3};
  return frame;
}

std::vector<float> ByKernels(const Poser& poser, const Poser::Parameters& frame) {
  FlameRig<float> rig;
  poser.Prepare(frame, rig);
  const PosingArrays<float> arrays = poser.Arrays();
  std::vector<float> unskinned(3 * arrays.vertex_count), vertices(unskinned.size());
  const flame_math::BlendShapesKernel<float> blend{arrays,
                                                   rig.terms.data(),
                                                   rig.expression_terms,
                                                   rig.terms.size() - rig.expression_terms,
                                                   unskinned.data()};
  for (size_t i = 0; i < unskinned.size(); ++i) blend(i);
  const flame_math::SkinKernel<float> skin(rig, arrays.weights, unskinned.data(), vertices.data());
  for (size_t v = 0; v < arrays.vertex_count; ++v) skin(v);
  return vertices;
}

TEST(Posing, KernelsGiveTheBitsOfForward) {
  const FlameModel model = RandomModel(300, 3, 11);
  const Poser poser(model, {0.5f, -2});
  for (const Poser::Parameters& frame : {Poser::Parameters{},
                                         FrameOf({}),
                                         FrameOf({0, 0, 1}),
                                         FrameOf({1, 0, -1, 2, 0.5f}),
                                         FrameOf(std::vector<float>(11, 0.3f))}) {
    std::vector<float> forward;
    poser.Forward(frame, forward);
    EXPECT_EQ(ByKernels(poser, frame), forward);
  }
}

TEST(Posing, ZeroCoefficientsAreLeftOut) {
  const FlameModel model = RandomModel();
  const Poser poser(model, {});
  FlameRig<float> rig;
  poser.Prepare({}, rig);
  EXPECT_TRUE(rig.terms.empty());
  Poser::Parameters frame;
  frame.expression = {0, 2, 0};
  frame.pose[2] = {0, 0, 0.4f};  // the jaw: four of its nine features change
  poser.Prepare(frame, rig);
  ASSERT_EQ(rig.expression_terms, 1u);
  EXPECT_EQ(rig.terms[0].direction, 1);
  EXPECT_EQ(rig.terms[0].coefficient, 2);
  EXPECT_EQ(rig.terms.size(), 5u);
  for (size_t t = 1; t < rig.terms.size(); ++t) EXPECT_EQ(rig.terms[t].direction / 9, 1);
}

TEST(Posing, RefusesWhatForwardRefuses) {
  const FlameModel model = RandomModel();
  const Poser poser(model, {});
  FlameRig<float> rig;
  poser.Prepare(FrameOf({1}), rig);
  const size_t before = rig.terms.size();
  Poser::Parameters bad = FrameOf({});
  bad.pose[3][1] = std::numeric_limits<float>::quiet_NaN();
  ExpectError([&] { poser.Prepare(bad, rig); }, {"random", "pose[1]"});
  ExpectError([&] { poser.Prepare(FrameOf({2e6f}), rig); }, {"random", "expression[0]"});
  ExpectError([&] { poser.Prepare(FrameOf({0, 0, 0, 0, 1}), rig); }, {"expression[4]"});
  EXPECT_EQ(rig.terms.size(), before);
}

// A model's numbers are finite, but have no other limit.
TEST(Posing, ReachIsAnUpperBound) {
  FlameModel model = RandomModel();
  const auto check = [&](const Poser::Parameters& frame) {
    const Poser poser(model, {});
    FlameRig<float> rig;
    poser.Prepare(frame, rig);
    PosingReach(poser.Arrays()).Check(rig);
  };
  check(FrameOf({1e6f, -1e6f}));
  model.expression_directions[5] = 1e36f;
  check(FrameOf({0, 1}));
  check(FrameOf({1}));
  ExpectError([&] { check(FrameOf({1000})); }, {"vertices", "float"});
  model.expression_directions[5] = 0;
  model.template_vertices[7] = 3e38f;
  ExpectError([&] { check(FrameOf({})); }, {"vertices", "float"});
}

TEST(Posing, ReachKeepsANaN) {
  const FlameModel model = RandomModel();
  const Poser poser(model, {});
  FlameRig<float> rig;
  poser.Prepare(FrameOf({}), rig);
  rig.transforms.rotation[1].m[3] = std::numeric_limits<float>::quiet_NaN();  // finite ones follow
  ExpectError([&] { PosingReach(poser.Arrays()).Check(rig); }, {"vertices"});
}

}  // namespace
}  // namespace cosplat::test

// avatar/model/avatar_mesh.h: the canonical mesh, the bust, and somebody else's motion.
#include "avatar/model/avatar_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "assets/head/procedural_head.h"
#include "avatar/surface/surface.h"
#include "splat/base/rng.h"
#include "splat/math/quat.h"

namespace cosplat::test {
namespace {

const FlameModel& Flame() {
  static const FlameModel model = MakeProceduralHead();
  return model;
}

FlameParams Root(std::array<float, 3> rotation, std::array<float, 3> translation) {
  FlameParams p;
  p.pose[0] = rotation;
  p.translation = translation;
  return p;
}

math::Mat3<float> Rotation(const std::array<float, 3>& r) {
  const float angle = std::hypot(r[0], r[1], r[2]);
  const float s = angle > 0 ? std::sin(angle / 2) / angle : 0.5f;
  return math::RotationOf(math::Quat<float>{std::cos(angle / 2), r[0] * s, r[1] * s, r[2] * s});
}

void ExpectSameRotation(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  const math::Mat3<float> ra = Rotation(a), rb = Rotation(b);
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(ra.m[i], rb.m[i], 1e-5f) << i;
}

TEST(AvatarMesh, IsTheSubjectsShapeAtRest) {
  const std::vector<float> shape{1.5f, -0.5f};
  std::vector<float> offset(3 * size_t(Flame().vertex_count), 0.0f);
  offset[7] = 0.01f;
  const CanonicalMesh mesh = MakeCanonicalMesh(Flame(), shape, offset, {});
  EXPECT_EQ(mesh.faces, Flame().faces);
  ASSERT_EQ(mesh.vertices.size(), offset.size());
  for (size_t i = 0; i < offset.size(); ++i) {
    const float expected = Flame().template_vertices[i] + offset[i] +
                           1.5f * Flame().shape_directions[i] -
                           0.5f * Flame().shape_directions[offset.size() + i];
    ASSERT_NEAR(mesh.vertices[i], expected, 1e-6f) << i;
  }
}

TEST(AvatarMesh, TheBustHangsBelowTheNeckAndLooksForward) {
  const CanonicalMesh head = MakeCanonicalMesh(Flame(), {}, {}, {});
  const CanonicalMesh mesh = MakeCanonicalMesh(Flame(), {}, {}, Bust{});
  ASSERT_GT(mesh.faces.size(), head.faces.size());
  EXPECT_TRUE(std::equal(head.vertices.begin(), head.vertices.end(), mesh.vertices.begin()));
  EXPECT_TRUE(std::equal(head.faces.begin(), head.faces.end(), mesh.faces.begin()));
  const Surface surface(mesh);  // a manifold
  EXPECT_EQ(surface.topology().component_count, Surface(head).topology().component_count + 1);
  float lowest = 1, left = 1, right = -1, top = -1, bottom = 1;
  for (size_t i = 0; i < head.vertices.size(); i += 3)
    lowest = std::min(lowest, head.vertices[i + 1]);
  for (size_t i = head.vertices.size(); i < mesh.vertices.size(); i += 3) {
    left = std::min(left, mesh.vertices[i]);
    right = std::max(right, mesh.vertices[i]);
    top = std::max(top, mesh.vertices[i + 1]);
    bottom = std::min(bottom, mesh.vertices[i + 1]);
    EXPECT_GT(surface.canonical()[i / 3].normal.z, 0) << i / 3;
  }
  EXPECT_GT(right - left, 0.4f);  // metres: shoulders
  EXPECT_LT(right - left, 1.0f);
  EXPECT_NEAR(left, -right, 0.02f);
  EXPECT_GT(top, lowest);  // over the neck's rim
  EXPECT_LT(top, lowest + 0.08f);
  EXPECT_LT(bottom, lowest - 0.2f);
}

TEST(AvatarPoser, PosesTheHeadAsFlameDoesAndHoldsTheBust) {
  const Bust bust{{0, 0, 1, 0, 1, 0, -1, 0, 0}, {0.1f, 0.2f, 0.3f}};  // a quarter turn about y
  const CanonicalMesh mesh = MakeCanonicalMesh(Flame(), {}, {}, bust);
  AvatarPoser poser(Flame(), {}, {}, bust);
  ASSERT_EQ(3 * poser.vertex_count(), mesh.vertices.size());
  FlameParams params = Root({0.1f, 0.4f, -0.2f}, {0.01f, 0.02f, 0.03f});
  params.expression = {0.5f, 1};
  std::vector<float> posed, head;
  poser.Forward(poser.ParametersFor(params), posed);
  const FlamePoser<float> flame(Flame(), {});
  flame.Forward(FlamePoser<float>::ParametersOf(params), head);
  ASSERT_EQ(posed.size(), mesh.vertices.size());
  EXPECT_TRUE(std::equal(head.begin(), head.end(), posed.begin()));
  for (size_t i = head.size(); i < posed.size(); i += 3) {
    const float* p = &mesh.vertices[i];
    EXPECT_NEAR(posed[i], p[2] + 0.1f, 1e-6f);
    EXPECT_NEAR(posed[i + 1], p[1] + 0.2f, 1e-6f);
    EXPECT_NEAR(posed[i + 2], -p[0] + 0.3f, 1e-6f);
  }

  // What pulls at the bust does not pull at the head's parameters.
  std::vector<float> d_vertices(posed.size(), 0.0f);
  std::fill(d_vertices.begin() + long(head.size()), d_vertices.end(), 1.0f);
  const auto none = poser.Backward(poser.ParametersFor(params), d_vertices);
  EXPECT_EQ(none.translation, (std::array<float, 3>{0, 0, 0}));
  std::fill(d_vertices.begin(), d_vertices.end(), 1.0f);
  const auto some = poser.Backward(poser.ParametersFor(params), d_vertices);
  EXPECT_NEAR(some.translation[0], float(Flame().vertex_count), 0.1f);
}

TEST(MeanRoot, IsTheMiddleOfTurns) {
  const FlameParams mean =
      MeanRoot({Root({0, 0.2f, 0}, {1, 0, 0}), Root({0, -0.4f, 0}, {3, 2, -2})});
  EXPECT_NEAR(mean.pose[0][1], -0.1f, 1e-5f);
  EXPECT_NEAR(mean.pose[0][0], 0, 1e-6f);
  EXPECT_EQ(mean.translation, (std::array<float, 3>{2, 1, -1}));
  // The same turn written the long way round: quaternions of the other sign.
  const float around = 0.3f - 6.2831853f;
  ExpectSameRotation(MeanRoot({Root({0.3f, 0, 0}, {}), Root({around, 0, 0}, {})}).pose[0],
                     {0.3f, 0, 0});
  ExpectSameRotation(MeanRoot({Root({around, 0, 0}, {}), Root({0.3f, 0, 0}, {})}).pose[0],
                     {0.3f, 0, 0});
}

TEST(HeadTurns, AreThoseOfRootAndNeckTogether) {
  std::vector<FlameParams> frames(4);
  frames[0].pose[0] = {0.3f, 0, 0};
  frames[1].pose[1] = {-0.3f, 0, 0};
  frames[2].pose[0] = {0, 0.4f, 0};
  frames[2].pose[1] = {0, -0.4f, 0};
  const std::vector<float> turns = HeadTurns(frames);
  for (const auto& [frame, turn] : {std::pair{0u, 0.3f}, {1u, 0.3f}, {2u, 0.0f}, {3u, 0.0f}})
    EXPECT_NEAR(turns[frame], turn, 2e-3f) << frame;
}

TEST(Retarget, OntoItsOwnMeanChangesNothing) {
  Rng rng{3};
  std::vector<FlameParams> frames;
  for (int i = 0; i < 20; ++i) {
    frames.push_back(Root({0.3f * rng.Normal() + 3, 0.3f * rng.Normal(), 0.3f * rng.Normal()},
                          {rng.Normal(), rng.Normal(), rng.Normal()}));
    frames.back().pose[2] = {rng.Uniform(), 0, 0};
    frames.back().expression = {rng.Normal()};
  }
  const std::vector<FlameParams> same = Retarget(frames, MeanRoot(frames));
  for (size_t i = 0; i < frames.size(); ++i) {
    ExpectSameRotation(same[i].pose[0], frames[i].pose[0]);
    EXPECT_EQ(same[i].pose[2], frames[i].pose[2]);
    EXPECT_EQ(same[i].expression, frames[i].expression);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(same[i].translation[k], frames[i].translation[k], 1e-5f);
  }
}

// A head that nods before a camera of OpenCV's, upside down in FLAME's axes, makes one nod that
// stands upright in its own world.
TEST(Retarget, MovesAboutTheAvatarsOwnRest) {
  const float pi = 3.14159265f;
  std::vector<FlameParams> frames;
  for (const float nod : {-0.2f, 0.0f, 0.2f}) frames.push_back(Root({pi + nod, 0, 0}, {0, 0, 5}));
  frames[2].translation[1] = 0.3f;
  const FlameParams rest = Root({0, 0, 0}, {0.5f, 0, 0});
  const std::vector<FlameParams> moved = Retarget(frames, rest);
  const FlameParams mean = MeanRoot(moved);
  ExpectSameRotation(mean.pose[0], rest.pose[0]);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean.translation[k], rest.translation[k], 1e-5f);
  for (int i = 0; i < 3; ++i) ExpectSameRotation(moved[i].pose[0], {0.2f * float(i - 1), 0, 0});
  EXPECT_NEAR(moved[2].translation[1] - moved[0].translation[1], 0.3f, 1e-5f);
}

// At the mean pose the bust's neck is where the head's is.
TEST(MeanBust, StandsWhereTheHeadIsOnAverage) {
  const std::vector<FlameParams> frames{Root({0.1f, 0.5f, 0}, {0.2f, 0, 1}),
                                        Root({0.1f, 0.3f, 0}, {0.2f, 0.1f, 1})};
  const Bust bust = MeanBust(Flame(), {}, {}, frames);
  const CanonicalMesh mesh = MakeCanonicalMesh(Flame(), {}, {}, bust);
  std::vector<float> posed;
  AvatarPoser poser(Flame(), {}, {}, bust);
  poser.Forward(poser.ParametersFor(MeanRoot(frames)), posed);
  // Rigid as a whole: distances between vertices of head and bust are those of the rest pose.
  const size_t bust_begin = size_t(Flame().vertex_count), n = mesh.vertices.size() / 3;
  const auto distance = [](const std::vector<float>& v, size_t a, size_t b) {
    return std::hypot(
        v[3 * a] - v[3 * b], v[3 * a + 1] - v[3 * b + 1], v[3 * a + 2] - v[3 * b + 2]);
  };
  for (size_t a = 0; a < bust_begin; a += 397)
    for (size_t b = bust_begin; b < n; b += 101)
      EXPECT_NEAR(distance(posed, a, b), distance(mesh.vertices, a, b), 1e-4f) << a << " " << b;
}

TEST(RestRoot, IsTheRootThatTheBustWasMadeFor) {
  AvatarModel avatar;
  avatar.static_offset.assign(3 * size_t(Flame().vertex_count), 1e-3f);
  for (const std::array<float, 3>& turn :
       {std::array<float, 3>{0, 0, 0}, {0.1f, 0.5f, -0.3f}, {3.1f, 0, 0.2f}, {0, 3.14159265f, 0}}) {
    const FlameParams root = Root(turn, {0.2f, -0.1f, 1});
    avatar.bust = MeanBust(Flame(), avatar.shape, avatar.static_offset, {root});
    const FlameParams rest = RestRoot(avatar, Flame());
    ExpectSameRotation(rest.pose[0], root.pose[0]);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(rest.translation[k], root.translation[k], 1e-5f);
    EXPECT_TRUE(rest.expression.empty());
  }
}

TEST(RestRoot, WithoutABustIsWhereTheMeshIs) {
  AvatarModel avatar;
  EXPECT_EQ(RestRoot(avatar, Flame()).pose[0], (std::array<float, 3>{0, 0, 0}));
  avatar.canonical_frame = Root({0.1f, 0.5f, 0}, {0.2f, 0, 1});
  avatar.canonical_frame->expression = {1};
  const FlameParams rest = RestRoot(avatar, Flame());
  EXPECT_EQ(rest.pose, avatar.canonical_frame->pose);
  EXPECT_EQ(rest.translation, avatar.canonical_frame->translation);
  EXPECT_TRUE(rest.expression.empty());
}

}  // namespace
}  // namespace cosplat::test

// avatar/surface/binding.h: each fault of SplattingAvatar's release is there where an
// embedding asks for it, and not where it does not.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "avatar/math/released_embed.h"
#include "avatar/surface/binding.h"
#include "tests/avatar/meshes.h"
#include "tests/support/expect_error.h"
#include "tests/support/gradient_check.h"

namespace cosplat::test {
namespace {

using math::Quat;
using math::Three;
using math::Vec3;

PosedGaussians Bound(const AvatarModel& model, const Surface& surface) {
  PosedGaussians out;
  Bind(model, surface, out);
  return out;
}

AvatarModel Released(AvatarModel model) {
  model.embedding.released = ReleasedRule{MeshUnit(model.mesh)};
  return model;
}

// A ball about as large as a head, so that the release's unit of length means something.
CanonicalMesh Ball() { return SphereMesh(3, 0.1f); }

AvatarModel OnBall(size_t n, unsigned seed) {
  AvatarModel model = RandomAvatar(Ball(), n, seed);
  for (size_t i = 0; i < n; ++i) model.gaussians.values[kPosition][3 * i + 2] *= 0.1f;
  for (float& s : model.gaussians.values[kScaleLog]) s -= 3;  // millimetres
  return model;
}

TEST(ReleasedBinding, AtRestGivesTheEmbeddedGaussianOnItsPlaceWithoutItsStep) {
  AvatarModel model = OnBall(50, 1);
  Surface surface(model.mesh);
  const PosedGaussians released = Bound(Released(model), surface);
  for (size_t i = 0; i < model.size(); ++i)
    for (int k = 0; k < 2; ++k) model.gaussians.values[kPosition][3 * i + k] = 0;
  const PosedGaussians ours = Bound(model, surface);
  for (size_t i = 0; i < ours.position.size(); ++i) {
    EXPECT_NEAR(released.position[i], ours.position[i], 1e-6f);
    EXPECT_NEAR(released.scale_log[i], ours.scale_log[i], 1e-5f);
  }
  for (size_t i = 0; i < ours.rotation.size(); ++i)
    EXPECT_NEAR(released.rotation[i], ours.rotation[i], 1e-5f);
}

// Half the area: ours shrinks by the root of it, the release's grows several times.
TEST(ReleasedBinding, ScalesTheWrongWayRound) {
  const AvatarModel model = OnBall(50, 2);
  Surface surface(model.mesh);
  surface.Pose(Scaled(model.mesh, std::sqrt(0.5f)).vertices);
  const PosedGaussians ours = Bound(model, surface), released = Bound(Released(model), surface);
  const auto& local = model.gaussians.values[kScaleLog];
  for (size_t i = 0; i < local.size(); ++i) {
    EXPECT_NEAR(ours.scale_log[i] - local[i], 0.5 * std::log(0.5), 1e-4);
    EXPECT_GT(released.scale_log[i] - local[i], std::log(2.0));
  }
}

double Agreement(const PosedGaussians& posed, size_t i, const Quat<double>& q) {
  const float* f = &posed.frame[4 * i];
  return std::abs(q.w * f[0] + q.x * f[1] + q.y * f[2] + q.z * f[3]);
}

// A turn of 120 degrees about (1, -1, 1): w, x, -y and z of its quaternion are equal, so that
// rounding decides which of them is made positive, and with it the sign, face by face.
TEST(ReleasedBinding, BlendsAwayRotationsWhoseSignsDiffer) {
  const AvatarModel model = OnBall(400, 3);
  const float a = float(1 / std::sqrt(3.0));
  std::vector<float> posed = Turned(model.mesh.vertices, {a, -a, a}, 2 * M_PI / 3);
  std::mt19937 rng(4);
  std::normal_distribution<float> noise(0, 1e-4f);
  for (float& x : posed) x += noise(rng);
  Surface surface(model.mesh);
  surface.Pose(posed);
  const Quat<double> q{.5, .5, -.5, .5};
  const PosedGaussians ours = Bound(model, surface), released = Bound(Released(model), surface);
  int wrong = 0;
  for (size_t i = 0; i < model.size(); ++i) {
    EXPECT_GT(Agreement(ours, i, q), 0.999);
    wrong += Agreement(released, i, q) < 0.99;
  }
  EXPECT_GT(wrong, 20);  // measured: 33 of 400
}

// Where no sign differs the release turns Gaussians as ours does.
TEST(ReleasedBinding, FollowsSmallTurns) {
  const AvatarModel model = OnBall(100, 5);
  Surface surface(model.mesh);
  surface.Pose(Turned(model.mesh.vertices, {0, 0.6f, 0.8f}, 0.4));
  const PosedGaussians released = Bound(Released(model), surface);
  for (size_t i = 0; i < model.size(); ++i)
    EXPECT_GT(Agreement(released, i, {std::cos(.2), 0, .6 * std::sin(.2), .8 * std::sin(.2)}),
              0.9999);
}

PosedGaussians RandomAdjoint(size_t n) {
  std::mt19937 rng(6);
  std::normal_distribution<float> normal;
  PosedGaussians d;
  d.Resize(n);
  for (Buffer<float>* b : {&d.position, &d.rotation, &d.scale_log, &d.frame})
    for (float& x : *b) x = normal(rng);
  return d;
}

TEST(ReleasedBinding, StepsOnTheSurfaceGetNoGradientButOursDo) {
  const AvatarModel model = OnBall(60, 7);
  Surface surface(model.mesh);
  surface.Pose(Turned(model.mesh.vertices, {1, 0, 0}, 0.3));
  const PosedGaussians d = RandomAdjoint(model.size());
  Gaussians ours, released;
  BindBackward(model, surface, d, ours);
  BindBackward(Released(model), surface, d, released);
  for (size_t i = 0; i < model.size(); ++i) {
    const float *a = &ours.values[kPosition][3 * i], *b = &released.values[kPosition][3 * i];
    EXPECT_NE(a[0], 0);
    EXPECT_NE(a[1], 0);
    EXPECT_EQ(b[0], 0);
    EXPECT_EQ(b[1], 0);
    EXPECT_NE(b[2], 0);
  }
}

// Layout of x: offset 3, rotation 4, scale 3.
template <class T>
math::EmbeddedGaussian<T> LocalOf(const std::vector<T>& x) {
  return {T(.3), T(.25), {x[0], x[1], x[2]}, {x[3], x[4], x[5], x[6]}, {x[7], x[8], x[9]}};
}
template <class T>
Three<math::SurfaceVertex<T>> Corners() {
  const auto r = RandomVector(30, 8);
  Three<math::SurfaceVertex<T>> v;
  for (int c = 0; c < 3; ++c) {
    const double* a = &r[10 * c];
    v[c] = {{T(a[0]), T(a[1]), T(a[2])},
            {T(a[3]), T(a[4]), T(a[5])},
            {T(2 + a[6]), T(a[7]), T(a[8]), T(a[9])},
            T(1)};
  }
  return v;
}

TEST(ReleasedBinding, VjpMatchesDualNumbers) {
  for (unsigned seed = 0; seed < 10; ++seed)
    ExpectVjpMatchesDual(
        [](const auto& x) {
          using T = std::decay_t<decltype(x[0])>;
          const auto p = math::ReleasedEmbed(Corners<T>(), {T(2e-5), T(1e-5), T(.25)}, LocalOf(x));
          return std::vector<T>{p.position.x,
                                p.position.y,
                                p.position.z,
                                p.rotation.w,
                                p.rotation.x,
                                p.rotation.y,
                                p.rotation.z,
                                p.scale_log.x,
                                p.scale_log.y,
                                p.scale_log.z};
        },
        [](const auto& x, const auto& d) {
          math::EmbeddedGaussian<double> g;
          math::ReleasedEmbedVjp(
              Corners<double>(),
              {2e-5, 1e-5, .25},
              LocalOf(x),
              {{d[0], d[1], d[2]}, {d[3], d[4], d[5], d[6]}, {d[7], d[8], d[9]}, {}},
              g);
          return std::vector<double>{g.offset.x,
                                     g.offset.y,
                                     g.offset.z,
                                     g.rotation.w,
                                     g.rotation.x,
                                     g.rotation.y,
                                     g.rotation.z,
                                     g.scale_log.x,
                                     g.scale_log.y,
                                     g.scale_log.z};
        },
        RandomVector(10, seed));
}

// That BindBackward is the derivative of Bind: the loops around the formula.
TEST(ReleasedBinding, GradientsMatchFiniteDifferences) {
  AvatarModel model = Released(OnBall(8, 9));
  Surface surface(model.mesh);
  surface.Pose(Turned(Scaled(model.mesh, 1.2f).vertices, {0.6f, 0, 0.8f}, 0.9));
  const PosedGaussians d = RandomAdjoint(model.size());
  const auto inner = [&] {
    const PosedGaussians out = Bound(model, surface);
    double sum = 0;
    for (size_t i = 0; i < out.position.size(); ++i)
      sum += double(d.position[i]) * out.position[i] + double(d.scale_log[i]) * out.scale_log[i];
    for (size_t i = 0; i < out.rotation.size(); ++i) sum += double(d.rotation[i]) * out.rotation[i];
    return sum;
  };
  Gaussians d_gaussians;
  BindBackward(model, surface, d, d_gaussians);
  for (const Attribute a : {kPosition, kRotation, kScaleLog})
    for (size_t i = 0; i < model.gaussians.values[a].size(); ++i) {
      const float h = 2e-3f;  // as in surface_test.cpp
      float& x = model.gaussians.values[a][i];
      const float at = x;
      x = at + h;
      const double up = inner();
      x = at - h;
      const double expected = (up - inner()) / (2.0 * h);
      x = at;
      EXPECT_NEAR(d_gaussians.values[a][i], expected, 5e-3 * (1 + std::abs(expected)));
    }
}

TEST(ReleasedBinding, BitsDoNotDependOnThreads) {
  const AvatarModel model = Released(OnBall(5000, 10));
  const PosedGaussians d = RandomAdjoint(model.size());
  const auto run = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
    Surface surface(model.mesh);
    surface.Pose(Turned(model.mesh.vertices, {0, 1, 0}, 2));
    Gaussians d_gaussians;
    BindBackward(model, surface, d, d_gaussians);
    return std::pair(Bound(model, surface).rotation, d_gaussians.values[kScaleLog]);
  };
  EXPECT_EQ(run(1), run(4));
}

TEST(ReleasedBinding, ACollapsedMeshIsFinite) {
  const AvatarModel model = Released(OnBall(50, 11));
  Surface surface(model.mesh);
  surface.Pose(std::vector<float>(model.mesh.vertices.size(), 0.25f));
  const PosedGaussians out = Bound(model, surface);
  for (const Buffer<float>* b : {&out.position, &out.rotation, &out.scale_log, &out.frame})
    for (const float x : *b) EXPECT_TRUE(std::isfinite(x));
}

TEST(ReleasedBinding, TheMeshHasNoGradient) {
  const AvatarModel model = Released(OnBall(5, 12));
  Surface surface(model.mesh);
  Gaussians d_gaussians;
  Buffer<float> d_vertices;
  ExpectError([&] { BindBackward(model, surface, RandomAdjoint(5), d_gaussians, &d_vertices); },
              {"mesh", "released"});
}

}  // namespace
}  // namespace cosplat::test

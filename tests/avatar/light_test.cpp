#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "avatar/play/player.h"
#include "avatar/train/light_fit.h"
#include "splat/basis_constants.h"
#include "tests/avatar/meshes.h"
#include "tests/avatar/training_fixture.h"
#include "tests/avatar/with_corrections.h"
#include "tests/support/expect_error.h"
#include "tests/support/gradient_check.h"

namespace cosplat::test {
namespace {

const float kBlack = -0.5f / BasisConstants(Basis::kDcsh)[0];

Light SomeLight() {
  Light light;
  for (size_t k = 0; k < light.size(); ++k) light[k] = 0.3f * float(std::sin(1.7 * double(k + 1)));
  return light;
}

AvatarModel LitAvatar(const CanonicalMesh& mesh, size_t n) {
  AvatarModel model = RandomAvatar(mesh, n, 5);
  Rng rng{4};
  model.gaussians.values[kColorDc].resize(3 * n);
  model.gaussians.values[kOpacityLogit].resize(n);
  for (float& x : model.gaussians.values[kColorDc]) x = 0.4f * rng.Normal();
  model.light = SomeLight();
  return model;
}

std::vector<float> MeanTerms(size_t vertices) {
  std::vector<float> mean(vertices * size_t(math::kLightTerms));
  for (size_t i = 0; i < mean.size(); ++i) mean[i] = 0.4f * float(std::cos(0.9 * double(i)));
  return mean;
}

// A normal 3, a colour 3 -> the lit colour 3, under fixed coefficients.
struct LitFunction {
  template <class T>
  std::vector<T> operator()(const std::vector<T>& x) const {
    static const Light light = SomeLight();
    const auto terms = math::LightTermsOf(math::Vec3<T>{x[0], x[1], x[2]});
    const auto lit =
        math::Lit(math::Vec3<T>{x[3], x[4], x[5]}, math::LogLight(terms, light.data()), kBlack);
    return {lit.x, lit.y, lit.z};
  }
};
std::vector<double> LitFunctionVjp(const std::vector<double>& x, const std::vector<double>& d) {
  const Light light = SomeLight();
  const math::Vec3<double> n{x[0], x[1], x[2]};
  math::Vec3<double> d_dc, d_log;
  math::LitVjp({x[3], x[4], x[5]},
               math::LogLight(math::LightTermsOf(n), light.data()),
               kBlack,
               {d[0], d[1], d[2]},
               d_dc,
               d_log);
  const auto d_n = math::LightTermsOfVjp(n, math::LogLightVjp<double>(light.data(), d_log));
  return {d_n.x, d_n.y, d_n.z, d_dc.x, d_dc.y, d_dc.z};
}

TEST(LightFormula, VjpMatchesDual) {
  for (unsigned seed = 0; seed < 10; ++seed)
    ExpectVjpMatchesDual(LitFunction(), LitFunctionVjp, RandomVector(6, seed));
}

TEST(LightFormula, BlackStaysBlack) {
  const auto lit = math::Lit(math::Vec3<float>{kBlack, 0, kBlack}, {1, 1, -2}, kBlack);
  EXPECT_EQ(lit.x, kBlack);
  EXPECT_GT(lit.y, 0);
  EXPECT_EQ(lit.z, kBlack);
}

// The sphere's normals are its vertices, so that the colours follow from the places.
TEST(Light, FollowsTheNormalInTheWorld) {
  const CanonicalMesh mesh = SphereMesh(4);
  AvatarModel model = LitAvatar(mesh, 200);
  model.light->fill(0);
  (*model.light)[3] = (*model.light)[4] = (*model.light)[5] = 0.5f;  // from above, along y
  Surface surface(mesh);
  PosedGaussians rest, turned;
  Bind(model, surface, rest);
  surface.Pose(Turned(mesh.vertices, {1, 0, 0}, M_PI));
  Bind(model, surface, turned);
  for (size_t i = 0; i < model.size(); ++i) {
    const auto& [u, v] = model.embedding.barycentric[i];
    const auto& f = mesh.faces[size_t(model.embedding.triangle[i])];
    const float y = u * mesh.vertices[3 * size_t(f[0]) + 1] +
                    v * mesh.vertices[3 * size_t(f[1]) + 1] +
                    (1 - u - v) * mesh.vertices[3 * size_t(f[2]) + 1];
    const float own = model.gaussians.at(kColorDc, i)[1] - kBlack;
    EXPECT_NEAR(rest.color_dc[3 * i + 1] - kBlack, own * std::exp(0.5f * y), 5e-2f * own);
    EXPECT_NEAR(turned.color_dc[3 * i + 1] - kBlack, own * std::exp(-0.5f * y), 5e-2f * own);
  }
  EXPECT_TRUE(rest.opacity_logit.empty());
  EXPECT_EQ(PosedView(model.gaussians, rest, model.color_frame).color_dc, rest.color_dc.data());
}

// A walk within a triangle makes (du, dv) part of (u, v).
TEST(Light, DoesNotJumpAtAWalk) {
  const CanonicalMesh mesh = SphereMesh(1);
  AvatarModel before = LitAvatar(mesh, 60), after = before;
  for (size_t i = 0; i < before.size(); ++i) {
    float* offset = before.gaussians.at(kPosition, i);
    offset[0] = 0.05f;
    offset[1] = -0.03f;
    float* walked = after.gaussians.at(kPosition, i);
    walked[0] = walked[1] = 0;
    after.embedding.barycentric[i][0] += 0.05f;
    after.embedding.barycentric[i][1] -= 0.03f;
  }
  Surface surface(mesh);
  surface.Pose(Turned(mesh.vertices, {0.6f, 0, 0.8f}, 0.4));
  PosedGaussians a, b;
  Bind(before, surface, a);
  Bind(after, surface, b);
  for (size_t i = 0; i < a.color_dc.size(); ++i) EXPECT_NEAR(a.color_dc[i], b.color_dc[i], 1e-5f);
}

// All that BindBackward gives for lit and corrected colours, against differences.
TEST(Light, BindBackwardIsTheDerivative) {
  const CanonicalMesh mesh = SphereMesh(1);
  FlameModel flame;
  AvatarModel model = WithCorrections(LitAvatar(mesh, 21), flame, 2);
  Surface surface(mesh);
  std::vector<float> vertices = Turned(mesh.vertices, {0.6f, 0, 0.8f}, 0.4);
  const std::vector<float> weights{0.7f, -0.4f}, mean = MeanTerms(mesh.vertices.size() / 3);
  const Appearance appearance{weights, *model.light, mean};
  const auto objective = [&] {
    PosedGaussians out;
    surface.Pose(vertices);
    Bind(model.gaussians, model.embedding, surface, out, appearance);
    double sum = 0;
    for (size_t i = 0; i < out.color_dc.size(); ++i)
      sum += std::sin(double(i + 1)) * out.color_dc[i];
    return sum;
  };
  objective();
  PosedGaussians d;
  d.Resize(model.size());
  for (Buffer<float>* b : {&d.position, &d.rotation, &d.scale_log})
    std::fill(b->begin(), b->end(), 0.0f);
  d.frame.clear();
  Gaussians d_gaussians;
  d_gaussians.Resize(model.size());
  for (size_t i = 0; i < 3 * model.size(); ++i)
    d_gaussians.values[kColorDc][i] = float(std::sin(double(i + 1)));
  Buffer<float> d_vertices, d_light;
  BindScratch scratch;
  BindBackward(model.gaussians,
               model.embedding,
               surface,
               d,
               d_gaussians,
               &d_vertices,
               scratch,
               appearance,
               &d_light);
  const auto check = [&](View<float> values, View<const float> gradient, const char* what) {
    ASSERT_EQ(values.size(), gradient.size()) << what;
    for (size_t k = 0; k < values.size(); ++k) {
      const float before = values[k], step = 2e-3f;
      values[k] = before + step;
      const double more = objective();
      values[k] = before - step;
      const double less = objective();
      values[k] = before;
      const double expected = (more - less) / (2.0 * step);
      EXPECT_NEAR(gradient[k], expected, 5e-3 * (1 + std::abs(expected))) << what << k;
    }
  };
  check(model.gaussians.values[kColorDc], d_gaussians.values[kColorDc], "colour ");
  check(model.gaussians.values[kCorrection], d_gaussians.values[kCorrection], "correction ");
  check(model.gaussians.values[kPosition], d_gaussians.values[kPosition], "offset ");
  check(*model.light, d_light, "light ");
  check(vertices, d_vertices, "vertex ");
}

TEST(Light, IsForOneRuleOnly) {
  const CanonicalMesh mesh = SphereMesh(1);
  AvatarModel model = LitAvatar(mesh, 5);
  PosedGaussians out;
  model.embedding.released = ReleasedRule{};
  ExpectError([&] { Bind(model, Surface(mesh), out); }, {"light", "released code"});
  model.embedding.released.reset();
  model.embedding.rigid = true;
  ExpectError([&] { Bind(model, Surface(mesh), out); }, {"light", "GaussianAvatars"});
  model.embedding.rigid = false;
  const std::vector<float> three{1, 2, 3};
  ExpectError(
      [&] {
        Bind(model.gaussians, model.embedding, Surface(mesh), out, {{}, three, {}});
      },
      {"light", "3 numbers"});
}

// However high its rate.
TEST(Light, StaysWithinItsBounds) {
  LightFit fit(MeanTerms(10), 100, 1000);
  for (const float sign : {1.0f, -1.0f}) {
    for (int i = 0; i < 20; ++i) {
      fit.gradient()->assign(kLightNumbers, sign * (i == 3 ? NAN : 1e3f));
      fit.Advance(nullptr);
    }
    const LightState state = fit.States()[0];
    for (const float value : state.value) EXPECT_EQ(value, -sign * math::kMaxLight);
  }
}

// What is trained with the terms less their mean is stored for playing without one.
TEST(Light, SettledAvatarLooksTheSame) {
  const CanonicalMesh mesh = SphereMesh(2);
  FlameModel flame;
  AvatarModel trained = WithCorrections(LitAvatar(mesh, 100), flame, 2);
  Surface surface(mesh);
  const std::vector<float> mean = MeanTerms(surface.vertex_count()), weights{0.7f, -0.4f};
  LightFit fit(mean, 1e-2f, 10);
  LightState state{};
  std::copy_n(trained.light->begin(), kLightNumbers, state.value);
  fit.SetStates({state});
  AvatarModel settled = trained;
  settled.light.reset();
  fit.Settle(settled);
  EXPECT_EQ(settled.light, trained.light);
  surface.Pose(Turned(mesh.vertices, {0.6f, 0, 0.8f}, 0.4));
  PosedGaussians a, b;
  Bind(trained.gaussians, trained.embedding, surface, a, {weights, fit.light(), fit.mean()});
  Bind(settled, surface, b, weights);
  for (size_t i = 0; i < a.color_dc.size(); ++i) EXPECT_NEAR(a.color_dc[i], b.color_dc[i], 2e-5f);
  LightFit none;
  AvatarModel unlit = trained;
  unlit.light.reset();
  none.Settle(unlit);
  EXPECT_FALSE(unlit.light);
}

// The head of a video is replaced by one that is lit by a known light.
TEST(Light, IsFoundInAVideo) {
  TrackedVideo video = LoadSmallVideo(20, 2);
  Training<> first(video, SmallAvatar(1500), ShortRun(100, 3000));
  first.Run(100);
  AvatarModel truth = first.Model();
  truth.light.emplace().fill(0);
  for (size_t c = 0; c < 3; ++c) (*truth.light)[3 + c] = 0.6f;  // from above, along y
  Player player(truth, SmallVideo::Get().flame);
  for (auto* frames : {&video.train, &video.test})
    for (TrackedFrame& frame : *frames) {
      frame.params.pose[0] = {frame.timestep % 5 * 0.3f - 0.6f, 0, 0};  // it nods
      frame.image = std::make_shared<const Image8>(player.Render(frame.params, frame.camera));
    }
  double psnr[2];
  for (const bool lit : {false, true}) {
    AvatarSettings avatar = SmallAvatar(1500);
    avatar.light_rate = lit ? 2e-2f : 0;  // of a run of thousands of steps
    avatar.iterations = 400;
    Training<> run(video, avatar, ShortRun(400, 3000));
    run.Run(400);
    const AvatarModel model = run.Model();
    ASSERT_EQ(model.light.has_value(), lit);
    psnr[lit] = MeanPsnr(model, video, video.test);
    for (size_t c = 0; lit && c < 3; ++c) EXPECT_NEAR((*model.light)[3 + c], 0.6f, 0.15f) << c;
  }
  EXPECT_GT(psnr[1], psnr[0] + 1);
}

}  // namespace
}  // namespace cosplat::test

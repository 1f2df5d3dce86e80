// `dcsh` is `sh` with the rest rate times sqrt(4 pi) and Adam's eps over sqrt(4 pi) (docs/dcsh.md):
// a basis scaled by r, trained with rate / r and eps * r, gives coefficients over r and otherwise
// the same run. For r a power of two the scaling is exact in floating point, so are the runs equal.
#include <gtest/gtest.h>

#include <algorithm>

#include "splat/basis_constants.h"
#include "splat/render/cpu/launch.h"
#include "splat/render/rasterizer.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/splat/training_fixture.h"

namespace cosplat {
namespace {

using namespace test;

constexpr float kRatio = 4;

// Shows coefficients times the ratio: what a basis scaled by it does with those stored.
class ScaledBasisSubject : public SceneSubject {
 public:
  using SceneSubject::SceneSubject;
  WorldGaussians ToWorld(const Gaussians& g, size_t i) override {
    rest_ = g.values[kColorRest];
    for (float& c : rest_) c *= kRatio;
    WorldGaussians world = SceneSubject::ToWorld(g, i);
    world.color_rest = rest_.data();
    return world;
  }
  void ToWorldBackward(const Gaussians&, Gaussians& gradients, const uint32_t*) override {
    for (float& d : gradients.values[kColorRest]) d *= kRatio;
  }

 private:
  Buffer<float> rest_;
};

// Counts what density control does.
class CountingSubject : public SceneSubject {
 public:
  CountingSubject(std::vector<TrainFrame> frames, size_t count)
      : SceneSubject(std::move(frames), 1), count_(count) {}
  void Gather(View<const uint32_t> source, Stream&) override {
    if (source.size() > count_) grown_ += source.size() - count_;
    count_ = source.size();
  }
  void Move(View<const float> offsets, size_t first, Gaussians& g, Stream& stream) override {
    moved_ += offsets.count / 3;
    SceneSubject::Move(offsets, first, g, stream);
  }
  size_t splits() const { return moved_ / 2; }
  size_t clones() const { return grown_ - splits(); }

 private:
  size_t count_, grown_ = 0, moved_ = 0;
};

TrainSettings FullDegreeRun() {
  TrainSettings settings = ShortRun(400, 3);
  settings.first_degree = 3;
  settings.schedule.densify_from = 20;
  settings.schedule.densify_every = 20;
  settings.schedule.opacity_reset_every = 70;
  settings.density.split_scale = 0.12f;  // about half of them each way
  settings.prune.rule = "dcsharp";
  return settings;
}

std::vector<TrainFrame> Frames() { return TargetImages(TrueScene(3), Ring(6, 2.2f)); }

Gaussians First(Basis basis) {
  Gaussians g = FirstGaussians(250, 3, Basis::kDcsh);
  Rng rng{6};
  for (float& c : g.values[kColorRest]) c = 0.05f * rng.Normal();
  ConvertBasis(g, basis);
  return g;
}

TEST(DcshIsSh, ARatioOfFourIsBitEqualThroughDensityControl) {
  const TrainSettings plain = FullDegreeRun();
  TrainSettings scaled = plain;
  scaled.rates.rest = plain.rates.RestRate() / kRatio;
  scaled.eps[kColorRest] *= kRatio;
  Gaussians first = First(Basis::kDcsh);
  CountingSubject plain_subject(Frames(), first.size());
  ScaledBasisSubject scaled_subject(Frames(), 1);
  Trainer a(plain, plain_subject, first);
  for (float& c : first.values[kColorRest]) c /= kRatio;
  Trainer b(scaled, scaled_subject, first);
  for (int step = 1; step <= 160; ++step) {  // two resets of opacity
    const double loss = a.Step().loss;
    ASSERT_EQ(loss, b.Step().loss) << "step " << step;
  }
  EXPECT_GT(plain_subject.clones(), 10u);
  EXPECT_GT(plain_subject.splits(), 10u);
  Gaussians back = b.state().gaussians;
  for (float& c : back.values[kColorRest]) c *= kRatio;
  EXPECT_TRUE(SameBits(a.state().gaussians, back));
  EXPECT_NE(a.state().gaussians.values[kColorRest], First(Basis::kDcsh).values[kColorRest]);
}

// The same through the renderer's own kernels, with a table of constants four times as large.
TEST(DcshIsSh, AScaledTableOfConstantsIsScaledCoefficients) {
  const Gaussians g = First(Basis::kDcsh);
  Gaussians over = g;
  for (float& c : over.values[kColorRest]) c /= kRatio;
  std::array<float, kMaxCoefficients> table;
  std::copy_n(BasisConstants(Basis::kDcsh), kMaxCoefficients, table.begin());
  for (int k = 1; k < kMaxCoefficients; ++k) table[k] *= kRatio;

  ViewParameters view = ViewOfCamera(Ring(1, 2.2f)[0], Basis::kDcsh, 3);
  struct Result {
    Buffer<ProjectedSplat> splats;
    Buffer<float> radii;
    Gaussians d;
  };
  const auto run = [&](const Gaussians& at, const float* constants) {
    view.basis_constants = constants;
    Result r;
    r.splats.resize(at.size());
    r.radii.resize(at.size());
    LaunchProject(ViewOf(at), view, r.splats.data(), r.radii.data());
    Buffer<SplatGradient> d_splats(at.size());
    Rng rng{8};
    for (SplatGradient& d : d_splats)
      d = {rng.Normal(), rng.Normal(), 0, 0, 0, 1, rng.Normal(), rng.Normal(), rng.Normal()};
    r.d = at.ZerosLike();
    Buffer<float> screen;
    LaunchProjectVjp(ViewOf(at),
                     view,
                     r.splats.data(),
                     r.radii.data(),
                     d_splats.data(),
                     GradientViewOf(r.d, screen));
    return r;
  };
  const Result plain = run(g, BasisConstants(Basis::kDcsh));
  Result scaled = run(over, table.data());
  size_t drawn = 0;
  for (size_t i = 0; i < g.size(); ++i) {
    if (!(plain.radii[i] > 0)) continue;
    ++drawn;
    EXPECT_EQ(plain.splats[i].r, scaled.splats[i].r);
    EXPECT_EQ(plain.splats[i].g, scaled.splats[i].g);
    EXPECT_EQ(plain.splats[i].b, scaled.splats[i].b);
  }
  EXPECT_GT(drawn, 200u);
  for (float& d : scaled.d.values[kColorRest]) d /= kRatio;
  EXPECT_TRUE(SameBits(plain.d, scaled.d));
}

struct BothBases {
  double image = 0;  // largest difference of a pixel
  double mean = 0;   // and the mean of them
  double rest = 0;   // largest difference of a higher band's coefficient
};

// Trains `dcsh` and `sh` with these rest rates (none: the default), the latter with its eps over
// `ratio`.
BothBases TrainBoth(float eps,
                    float ratio,
                    std::optional<float> dcsh_rest,
                    std::optional<float> sh_rest) {
  constexpr int kSteps = 60;
  TrainSettings dcsh = FullDegreeRun();
  dcsh.schedule.densify_from = 1000;
  dcsh.schedule.opacity_reset_every = 1000;
  dcsh.eps.fill(eps);
  TrainSettings sh = dcsh;
  dcsh.rates.rest = dcsh_rest;
  sh.rates.rest = sh_rest;
  sh.eps[kColorRest] /= ratio;
  SceneSubject subject(Frames(), 1);
  const Gaussians a = Train(dcsh, subject, First(Basis::kDcsh), kSteps).gaussians;
  Gaussians b = Train(sh, subject, First(Basis::kSh), kSteps).gaussians;
  BothBases both;
  size_t count = 0;
  for (const Camera& camera : Ring(6, 2.2f)) {
    const RenderedImage x = Render(a, camera), y = Render(b, camera);
    for (size_t i = 0; i < x.color.size(); ++i, ++count) {
      const double difference = std::abs(x.color[i] - y.color[i]);
      both.image = std::max(both.image, difference);
      both.mean += difference;
    }
  }
  both.mean /= double(count);
  ConvertBasis(b, Basis::kDcsh);
  for (size_t i = 0; i < a.values[kColorRest].size(); ++i)
    both.rest =
        std::max<double>(both.rest, std::abs(a.values[kColorRest][i] - b.values[kColorRest][i]));
  return both;
}

// What docs/dcsh.md tells users to give for --rest-lr.
TEST(DcshIsSh, TheRestRatesThatMakeThemAlike) {
  LearningRates rates;
  EXPECT_FLOAT_EQ(rates.RestRate(), 2.5e-3f / 20);
  EXPECT_NEAR(rates.RestRate() * std::sqrt(4 * M_PI), 4.431e-4, 5e-8);
  EXPECT_NEAR(rates.RestRate() / std::sqrt(4 * M_PI), 3.526e-5, 5e-9);
  rates.rest = 4.431e-4f;
  EXPECT_EQ(rates.RestRate(), 4.431e-4f);
}

TEST(DcshIsSh, TheTwoBasesTrainAlikeBeforeDensification) {
  const float ratio = std::sqrt(4 * float(M_PI));
  const float rate = FullDegreeRun().rates.RestRate();
  // An eps above the gradients' rounding noise: only rounding sets the two apart. Measured after
  // 60 steps: 5e-7 to 2e-5 in a pixel, by the compiler's options, and 3e-7 in a coefficient.
  const BothBases alike = TrainBoth(1e-6f, ratio, {}, ratio * rate);
  EXPECT_LT(alike.mean, 1e-6);         // 3e-8
  EXPECT_LT(alike.image, 2.0f / 255);  // a splat's rim may flip a pixel by one grey level
  EXPECT_LT(alike.rest, 1e-5);
  // The other way round: `dcsh` slowed down to `sh`.
  const BothBases slow = TrainBoth(1e-6f, ratio, rate / ratio, {});
  EXPECT_LT(slow.mean, 1e-6);
  EXPECT_LT(slow.image, 2.0f / 255);
  EXPECT_LT(slow.rest, 1e-5);
  // 3DGS's eps makes full steps of gradients that are rounding noise, so single Gaussians go their
  // own way; the image does not.
  const BothBases noisy = TrainBoth(1e-15f, ratio, {}, ratio * rate);
  EXPECT_LT(noisy.mean, 3e-3);  // measured 1.0e-3
  EXPECT_LT(noisy.image, 0.1);  // measured 0.027
  // It is the rates that make them alike: as they stand, the bases train differently.
  const BothBases apart = TrainBoth(1e-6f, 1, {}, {});
  EXPECT_GT(apart.rest, 1e3 * alike.rest);  // measured 0.038
  EXPECT_GT(apart.mean, 5e-3);              // measured 0.014
}

}  // namespace
}  // namespace cosplat

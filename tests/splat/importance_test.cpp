// What a Gaussian contributes to images, against images drawn without it.
#include "splat/train/prune/importance.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "splat/render/rasterizer.h"
#include "splat/train/loss/loss.h"
#include "splat/train/subject/scene_subject.h"
#include "splat/train/trainer.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/random_gaussians.h"

namespace cosplat {
namespace {

constexpr std::array<float, 3> kBackground{0.2f, 0.5f, 0.7f};

struct View {
  Gaussians gaussians;
  Camera camera;
  RenderedImage image;
  Buffer<Contribution> contributions;
};

RenderedImage Draw(const Gaussians& g, const Camera& camera) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {kBackground, g.degree}, image, *tape);
  return image;
}

// Few and faint enough that no pixel becomes opaque: taking one out then changes nothing but what
// it drew.
View FaintView(size_t count) {
  View v;
  v.gaussians = test::RandomGaussians(count, 1, Basis::kDcsh, 4);
  for (size_t i = 0; i < count; ++i) *v.gaussians.at(kOpacityLogit, i) -= 1;
  v.camera = test::LookingAt({0, 0, 3}, {0, 0, 0}, 40);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  rasterizer->Forward(ViewOf(v.gaussians),
                      v.gaussians.basis,
                      v.camera,
                      {kBackground, v.gaussians.degree},
                      v.image,
                      *tape);
  rasterizer->Contributions(v.image, *tape, v.contributions);
  return v;
}

TEST(Contributions, AreWhatTheImageLosesWithoutEach) {
  const View v = FaintView(30);
  int reached = 0;
  for (size_t i = 0; i < 30; ++i) {
    Gaussians without = v.gaussians;
    *without.at(kOpacityLogit, i) = -100;
    const RenderedImage image = Draw(without, v.camera);
    double change = 0;
    for (size_t k = 0; k < image.color.size(); ++k) {
      const double delta = double(v.image.color[k]) - image.color[k];
      change += delta * delta;
    }
    EXPECT_NEAR(v.contributions[i].change, change, 1e-4 * (1 + change)) << i;
    reached += change > 1e-3;
  }
  EXPECT_GT(reached, 20);
}

TEST(Contributions, WeightsAreTheShareOfTheImage) {
  const View v = FaintView(30);
  double weight = 0, covered = 0;
  for (const Contribution& c : v.contributions) {
    weight += c.weight;
    EXPECT_GE(c.hits, c.weight * 0.999f);  // a falloff is at most 1
  }
  for (const float t : v.image.transmittance) covered += 1 - t;
  EXPECT_NEAR(weight, covered, 1e-4 * covered);
}

TEST(Contributions, OneSplatByHand) {
  // One wide splat of opacity o before the background B: Delta = alpha (c - B).
  Gaussians g;
  g.Resize(1);
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, 0)[k] = std::log(0.2f);
  g.at(kRotation, 0)[0] = 1;
  *g.at(kOpacityLogit, 0) = 0;
  const Camera camera = test::LookingAt({0, 0, 3}, {0, 0, 0}, 32);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {kBackground, 0}, image, *tape);
  Buffer<Contribution> c;
  rasterizer->Contributions(image, *tape, c);
  double weight = 0, hits = 0, sensitivity = 0, change = 0;
  const double difference[3] = {0.5 - 0.2, 0.0, 0.5 - 0.7};
  for (const float t : image.transmittance) {
    const double alpha = 1 - t;
    if (alpha < kMinAlpha) continue;
    weight += alpha;
    hits += 0.5;
    sensitivity += std::pow(0.5 * (difference[0] + difference[2]), 2);
    change += alpha * alpha * (std::pow(difference[0], 2) + std::pow(difference[2], 2));
  }
  ASSERT_GT(hits, 20);
  EXPECT_NEAR(c[0].weight, weight, 1e-4 * weight);
  EXPECT_NEAR(c[0].hits, hits, 1e-4 * hits);
  EXPECT_NEAR(c[0].sensitivity, sensitivity, 1e-3 * sensitivity);
  EXPECT_NEAR(c[0].change, change, 1e-3 * change);
}

TEST(Contributions, OfWhatIsNotDrawnAreZero) {
  Gaussians g = test::RandomGaussians(3, 0, Basis::kDcsh, 4);
  g.at(kPosition, 1)[2] = 50;  // behind the camera
  g.at(kScaleLog, 2)[0] = NAN;
  const Camera camera = test::LookingAt({0, 0, 3}, {0, 0, 0}, 32);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {kBackground, 0}, image, *tape);
  Buffer<Contribution> c;
  rasterizer->Contributions(image, *tape, c);
  EXPECT_GT(c[0].weight, 0);
  for (const size_t i : {1, 2}) {
    EXPECT_EQ(c[i].weight, 0);
    EXPECT_EQ(c[i].change, 0);
  }
}

TEST(Contributions, BitsDoNotDependOnThreads) {
  std::vector<Buffer<Contribution>> results;
  for (const int threads : {1, 4}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(FaintView(200).contributions);
  }
  for (size_t i = 0; i < results[0].size(); ++i) {
    EXPECT_EQ(results[0][i].weight, results[1][i].weight);
    EXPECT_EQ(results[0][i].change, results[1][i].change);
  }
}

TEST(Importance, SumsOverFramesAndSparesTheRest) {
  const Gaussians truth = test::TrueScene(0);
  SceneSubject subject(test::TargetImages(truth, test::Ring(6, 2.2f)), 1);
  const std::vector<uint32_t> frames{0, 1, 2, 3, 4, 5};
  test::ImagesOf images(subject, truth);
  const auto all = images.Contributions({frames, 0, {0, 0, 0}, 100});
  const auto three = images.Contributions({frames, 0, {0, 0, 0}, 3});
  double sum_all = 0, sum_three = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    sum_all += all[i].weight;
    sum_three += three[i].weight;
  }
  EXPECT_NEAR(sum_three / sum_all, 0.5, 0.1);
}

TEST(Importance, SignificanceWeighsHitsByVolume) {
  Gaussians g;
  g.Resize(3);
  for (size_t i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) g.at(kScaleLog, i)[k] = float(i);
  const std::vector<Contribution> contributions{{0, 4, 0, 0}, {0, 2, 0, 0}, {0, 0, 0, 0}};
  // The 90 % quantile of three is the largest: log volume 6.
  const std::vector<float> s = Significance(g, contributions);
  EXPECT_NEAR(s[0], 4 * std::exp(0.1 * (0 - 6)), 1e-5);
  EXPECT_NEAR(s[1], 2 * std::exp(0.1 * (3 - 6)), 1e-5);
  EXPECT_EQ(s[2], 0);
  EXPECT_TRUE(Significance(Gaussians(), {}).empty());
}

}  // namespace
}  // namespace cosplat

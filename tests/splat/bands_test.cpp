// Bands of colour: their energy, dropping them, each Gaussian at its own degree through the
// renderer and files.
#include "splat/train/density/bands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "splat/basis_constants.h"
#include "splat/gaussians.h"
#include "splat/io/ply.h"
#include "splat/io/splat_file.h"
#include "splat/math/dcsh.h"
#include "tests/splat/training_fixture.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::RandomGaussians;

constexpr Basis kBases[] = {Basis::kDcsh, Basis::kSh, Basis::kDcshReleased, Basis::kDcshLiteral};

// By sampling the sphere at `count` points of a Fibonacci spiral.
double SampledEnergy(const Gaussians& g, size_t i, int band, int count) {
  double sum[3] = {};
  for (int s = 0; s < count; ++s) {
    const double z = 1 - (2 * s + 1.0) / count, phi = s * 2.399963229728653;
    const double rho = std::sqrt(1 - z * z);
    math::Vec3<float> u{float(rho * std::cos(phi)), float(rho * std::sin(phi)), float(z)};
    if (FoldsDirection(g.basis)) u = math::Fold(u);
    float basis[CoefficientCount(kMaxTrainedDegree)];
    math::EvaluateBasis<kMaxTrainedDegree>(u, BasisConstants(g.basis), basis);
    double color[3] = {};
    for (int k = CoefficientCount(band - 1); k < CoefficientCount(band); ++k)
      for (int c = 0; c < 3; ++c) color[c] += basis[k] * g.at(kColorRest, i)[3 * (k - 1) + c];
    for (int c = 0; c < 3; ++c) sum[c] += color[c] * color[c] / count;
  }
  return std::sqrt((sum[0] + sum[1] + sum[2]) / 3);
}

TEST(Bands, EnergyIsThatOverTheSphereInEveryBasis) {
  for (const Basis basis : kBases) {
    const Gaussians g = RandomGaussians(4, 4, basis, 3);
    for (size_t i = 0; i < g.size(); ++i)
      for (int band = 1; band <= 4; ++band) {
        const double sampled = SampledEnergy(g, i, band, 20000);
        // Measured: 9e-7 of it; for the literal basis, which jumps at x = 0, 4e-5.
        EXPECT_NEAR(BandEnergy(g, i, band), sampled, 2e-4 * sampled) << ToString(basis) << band;
      }
  }
}

// In every band the mean square of the Laplacian is the eigenvalue's square times that of the
// colour.
TEST(Bands, CurvatureIsThatOfTheEnergyInEveryBasis) {
  for (const Basis basis : {Basis::kDcsh, Basis::kSh}) {
    const Gaussians g = RandomGaussians(1, 4, basis, 3);
    EXPECT_EQ(CurvatureWeight(basis, 0), 0);
    for (int band = 1; band <= 4; ++band) {
      double sum = 0;
      for (int k = CoefficientCount(band - 1); k < CoefficientCount(band); ++k)
        for (int c = 0; c < 3; ++c)
          sum += CurvatureWeight(basis, k) * std::pow(g.at(kColorRest, 0)[3 * (k - 1) + c], 2);
      const double energy = BandEnergy(g, 0, band) * (band * (band + 1));
      EXPECT_NEAR(sum, 3 * energy * energy, 1e-5 * sum) << ToString(basis) << band;
    }
  }
}

TEST(Bands, EnergyDoesNotDependOnTheBasis) {
  Gaussians g = RandomGaussians(10, 4, Basis::kDcsh, 3);
  const Gaussians before = g;
  for (const Basis basis : test::kHarmonicBases) {
    ConvertBasis(g, basis);
    for (size_t i = 0; i < g.size(); ++i)
      for (int band = 1; band <= 4; ++band)
        EXPECT_NEAR(BandEnergy(g, i, band), BandEnergy(before, i, band), 1e-6);
  }
}

// Opaque, with this energy in each band.
Gaussians WithEnergies(const std::vector<std::array<float, 3>>& energies) {
  Gaussians g;
  g.degree = 3;
  g.Resize(energies.size());
  for (size_t i = 0; i < g.size(); ++i) {
    *g.at(kOpacityLogit, i) = 20;
    for (int band = 1; band <= 3; ++band)
      for (int c = 0; c < 3; ++c)
        g.at(kColorRest, i)[3 * (CoefficientCount(band - 1) - 1) + c] = energies[i][band - 1];
  }
  return g;
}

// Root mean square over the covered pixels of what cutting the Gaussians to their degrees changes.
double PredictedChange(const Gaussians& before, const Gaussians& after, const Weights& weights) {
  double sum = 0, covered = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    const double opacity = 1 / (1 + std::exp(-*before.at(kOpacityLogit, i)));
    for (int band = after.degrees[i] + 1; band <= before.degree; ++band)
      sum += weights[i] * opacity * std::pow(BandEnergy(before, i, band), 2);
    covered += weights[i];
  }
  return std::sqrt(sum / covered);
}

TEST(Bands, WhatChangesTheImagesLeastPerCoefficientGoes) {
  // Squared energies per coefficient: of 7, 5 and 3 in bands 3, 2 and 1.
  Gaussians g = WithEnergies({{1, 1, 1},
                              {1, 1, 0.1f},
                              {0, 1, 0.1f},      // a band below one that stays stays
                              {1, 0.05f, 0.1f},  // band 2 goes with band 3
                              {1, 0.2f, 0.02f},
                              {0, 0, 0}});
  const Gaussians before = g;
  const Weights weights(6, 1.0f);
  const float threshold = 0.075f;  // 6 of its squares: 0.034
  DropBands(weights, threshold, g);
  EXPECT_EQ(g.degrees, (Buffer<uint8_t>{3, 2, 2, 1, 2, 0}));
  EXPECT_LE(PredictedChange(before, g, weights), threshold);
  EXPECT_FLOAT_EQ(BandEnergy(g, 4, 2), 0.2f);
  EXPECT_EQ(BandEnergy(g, 4, 3), 0);
  const DegreeCounts counts = CountDegrees(g);
  EXPECT_EQ(counts, (DegreeCounts{1, 1, 3, 1, 0}));
  const DegreeFigures figures = FiguresOf(counts, g.degree);
  EXPECT_DOUBLE_EQ(figures.mean, 10.0 / 6);
  EXPECT_DOUBLE_EQ(figures.rest_saved, 1 - (3 + 3 * 8 + 15) / (6 * 15.0));
  // None comes back, not even with a threshold of nothing.
  const Buffer<uint8_t> degrees = g.degrees;
  DropBands(weights, 0, g);
  EXPECT_EQ(g.degrees, degrees);
  // All of it can go.
  DropBands(weights, 10, g);
  EXPECT_EQ(g.degrees, Buffer<uint8_t>(6, 0));
}

TEST(Bands, OpacityAndWeightCount) {
  const Gaussians before = WithEnergies({{1, 1, 0.1f}, {1, 1, 0.1f}});
  Gaussians g = before;
  *g.at(kOpacityLogit, 0) = 0;
  DropBands({1, 1}, 0.06f, g);  // 0.0072 of the squares, of 0.005 and 0.01
  EXPECT_EQ(g.degrees, (Buffer<uint8_t>{2, 3}));
  g = before;
  DropBands({1, 3}, 0.06f, g);  // 0.0144, of 0.01 and 0.03
  EXPECT_EQ(g.degrees, (Buffer<uint8_t>{2, 3}));
  g = before;
  DropBands({0, 1}, 1e-3f, g);  // in no image
  EXPECT_EQ(g.degrees, (Buffer<uint8_t>{0, 3}));
}

TEST(Bands, WhatIsNotFiniteStays) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              inf = std::numeric_limits<float>::infinity();
  for (const float bad : {nan, inf})
    for (int channel = 0; channel < 3; ++channel) {
      Gaussians g = WithEnergies({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
      g.at(kColorRest, 0)[3 * 3 + channel] = bad;  // band 2
      *g.at(kOpacityLogit, 1) = nan;
      DropBands({1, 1, 1}, 0.1f, g);
      EXPECT_EQ(g.degrees, (Buffer<uint8_t>{2, 3, 0}));
    }
}

TEST(Bands, TheImageChangesAsTheEnergiesTell) {
  Gaussians g = RandomGaussians(400, 3, Basis::kDcsh, 2);
  for (float& c : g.values[kColorRest]) c *= 0.2f;
  Weights weights(g.size(), 0);
  std::vector<RenderedImage> before;
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const auto render = [&](int k, const Gaussians& of) {
    const float a = 0.9f * float(k);
    const Camera camera =
        test::LookingAt({3 * std::cos(a), float(k % 3 - 1), 3 * std::sin(a)}, {0, 0, 0}, 48);
    RenderedImage image;
    rasterizer->Forward(ViewOf(of), of.basis, camera, {{0, 0, 0}, of.degree}, image, *tape);
    return image;
  };
  for (int k = 0; k < 7; ++k) {
    before.push_back(render(k, g));
    Buffer<Contribution> contributions;
    rasterizer->Contributions(before.back(), *tape, contributions);
    for (size_t i = 0; i < g.size(); ++i) weights[i] += contributions[i].weight;
  }
  const float threshold = 1 / 255.0f;
  DropBands(weights, threshold, g);
  double sum = 0, covered = 0;
  for (int k = 0; k < 7; ++k) {
    const RenderedImage after = render(k, g);
    for (size_t i = 0; i < after.color.size(); ++i)
      sum += std::pow(after.color[i] - before[k].color[i], 2) / 3;
    for (const float t : after.transmittance) covered += 1 - t;
  }
  const double change = std::sqrt(sum / covered);
  // alpha T is below the opacity, in these large Gaussians, which hide each other, far below.
  // Measured: 0.2 of the threshold.
  EXPECT_GT(change, 0.1 * threshold);
  EXPECT_LT(change, 1.1 * threshold);
}

TEST(Bands, NoneWithoutBands) {
  Gaussians g = RandomGaussians(5, 0, Basis::kDcsh, 1);
  DropBands(Weights(5, 1.0f), 1, g);
  EXPECT_EQ(g.degrees, Buffer<uint8_t>(5, 0));
  EXPECT_EQ(FiguresOf(CountDegrees(g), 0).rest_saved, 0);
  EXPECT_EQ(FiguresOf({}, 3).mean, 0);
}

// Gaussians of all degrees, at random, with zeros above their own.
Gaussians OfAllDegrees(size_t count, int degree, Basis basis) {
  Gaussians g = RandomGaussians(count, degree, basis, 11);
  for (size_t i = 0; i < count; ++i) g.degrees.push_back(uint8_t((i * 7 / 3) % (degree + 1)));
  ZeroAbove(g.degrees, g);
  return g;
}

TEST(Bands, DegreesAreFoundAndKept) {
  Gaussians g = OfAllDegrees(50, 3, Basis::kDcsh);
  const Buffer<uint8_t> degrees = g.degrees;
  g.degrees.clear();
  FindDegrees(g);
  EXPECT_EQ(g.degrees, degrees);
  ConvertBasis(g, Basis::kSh);
  FindDegrees(g);
  EXPECT_EQ(g.degrees, degrees);
  g.Gather({5, 5, 1});
  EXPECT_EQ(g.degrees, (Buffer<uint8_t>{degrees[5], degrees[5], degrees[1]}));
  g.Resize(4);
  EXPECT_EQ(g.degrees.back(), 3);
  EXPECT_TRUE(g.ZerosLike().degrees.empty());
  Gaussians full = RandomGaussians(20, 3, Basis::kDcsh, 1);
  FindDegrees(full);
  EXPECT_TRUE(full.degrees.empty());
}

TEST(Bands, SortedByDegreeTheImageIsTheSame) {
  Gaussians g = OfAllDegrees(203, 3, Basis::kDcsh);
  const Gaussians before = g;
  const std::vector<uint32_t> order = SortByDegree(g);
  ASSERT_EQ(order.size(), before.size());
  for (size_t i = 0; i < order.size(); ++i) {
    EXPECT_EQ(g.degrees[i], before.degrees[order[i]]);
    EXPECT_EQ(*g.at(kOpacityLogit, i), *before.at(kOpacityLogit, order[i]));
    if (i == 0) continue;
    EXPECT_GE(g.degrees[i], g.degrees[i - 1]);
    if (g.degrees[i] == g.degrees[i - 1]) {
      EXPECT_GT(order[i], order[i - 1]);
    }
  }
  const Camera camera = test::LookingAt({0.3f, -0.2f, -3}, {0, 0, 0}, 64);
  const RenderedImage sorted = test::Image(g, camera), as_it_was = test::Image(before, camera);
  // Compilers contract the sums of each degree in their own way.
  for (size_t i = 0; i < sorted.color.size(); ++i)
    ASSERT_NEAR(sorted.color[i], as_it_was.color[i], 1e-6f);
  Gaussians full = RandomGaussians(20, 3, Basis::kDcsh, 1);
  EXPECT_TRUE(SortByDegree(full).empty());
  EXPECT_EQ(full.size(), 20u);
}

struct Step {
  RenderedImage image;
  Gaussians gradients;
};
Step Differentiate(const Gaussians& g, int degree) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const Camera camera = test::LookingAt({0.3f, -0.2f, -3}, {0, 0, 0}, 64);
  Step step;
  Buffer<float> screen;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {{0.3f, 0.5f, 0.7f}, degree}, step.image, *tape);
  Buffer<float> d_color(step.image.color.size());
  Rng rng{4};
  for (float& d : d_color) d = rng.Normal();
  step.gradients = g.ZerosLike();
  for (Buffer<float>& values : step.gradients.values)  // all of it must be written
    std::fill(values.begin(), values.end(), 7.0f);
  rasterizer->Backward(
      ViewOf(g), step.image, d_color, *tape, GradientViewOf(step.gradients, screen));
  return step;
}

TEST(Bands, OwnDegreesChangeNoBitButGradientsOfWhatWasDropped) {
  for (const Basis basis : kBases)
    for (int degree = 0; degree <= 4; ++degree) {
      const Gaussians own = OfAllDegrees(203, 4, basis);  // the last pack is not full
      Gaussians all = own;
      all.degrees.clear();
      const Step a = Differentiate(own, degree);
      Step b = Differentiate(all, degree);
      EXPECT_TRUE(test::SameBits(a.image.color, b.image.color));
      EXPECT_FALSE(test::SameBits(a.gradients, b.gradients) && degree > 0);
      ZeroAbove(own.degrees, b.gradients);
      EXPECT_TRUE(test::SameBits(a.gradients, b.gradients)) << ToString(basis) << degree;
    }
}

TEST(Bands, DegreesGoThroughFiles) {
  const test::TemporaryFolder folder;
  Gaussians g = OfAllDegrees(60, 3, Basis::kSh);
  WritePly(folder / "a.ply", g);
  EXPECT_EQ(ReadSplats(folder / "a.ply").degrees, g.degrees);
  WriteSceneGlb(folder / "a.glb", g);
  EXPECT_EQ(ReadSplats(folder / "a.glb").degrees, g.degrees);
}

}  // namespace
}  // namespace cosplat

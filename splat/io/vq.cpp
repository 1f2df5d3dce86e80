#include "splat/io/vq.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "splat/base/error.h"
#include "splat/config.h"
#include "splat/io/kmeans.h"

namespace cosplat {
namespace {

// Minimum number of splats per codebook row: with fewer, a row costs more than it saves.
constexpr size_t kSplatsPerRow = 4;

// 1 for the `count` least significant; ties are resolved by index.
std::vector<uint8_t> LeastSignificant(View<const float> significance, size_t count) {
  std::vector<uint32_t> order(significance.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return significance[a] < significance[b];
  });
  std::vector<uint8_t> least(significance.size(), 0);
  for (size_t i = 0; i < count; ++i) least[order[i]] = 1;
  return least;
}

std::vector<float> UnitRotations(const Gaussians& g) {
  std::vector<float> rotations;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* q = g.at(kRotation, i);
    const float norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    for (int k = 0; k < 4; ++k)
      rotations.push_back(norm2 < kMinQuaternionNorm2 ? float(k == 0) : q[k] / std::sqrt(norm2));
  }
  return rotations;
}

void AppendBands(const Gaussians& g, size_t i, int degree, std::vector<float>& bands) {
  const float* rest = g.at(kColorRest, i);
  bands.insert(bands.end(), rest, rest + 3 * (CoefficientCount(degree) - 1));
}

QuantisedBands BandsOfDegree(const Gaussians& g,
                             const QuantisedSplats& splats,
                             int degree,
                             View<const float> weights,
                             const VqSettings& settings) {
  QuantisedBands bands;
  std::vector<float> rows, weight;
  for (size_t i = 0; i < g.size(); ++i) {
    if (splats.own_degree[i] != degree) continue;
    AppendBands(g, i, degree, splats.quantised[i] ? rows : bands.kept);
    if (splats.quantised[i]) weight.push_back(weights[i]);
  }
  KMeansSettings k_means;
  k_means.centers = std::clamp<size_t>(weight.size() / kSplatsPerRow, 1, size_t(settings.codebook));
  k_means.seed = settings.seed;
  const Clusters clusters = KMeans(rows, 3 * size_t(CoefficientCount(degree) - 1), weight, k_means);
  bands.codebook.assign(clusters.centers.begin(), clusters.centers.end());
  bands.index.assign(clusters.nearest.begin(), clusters.nearest.end());
  return bands;
}

}  // namespace

QuantisedSplats Quantise(const Gaussians& g,
                         View<const float> significance,
                         const VqSettings& settings) {
  if (g.basis != Basis::kSh)
    throw Error("basis", "is " + ToString(g.basis) + ", only sh can be quantised");
  const size_t n = g.size();
  const auto copied = [&](Attribute a) {
    return std::vector<float>(g.values[a].begin(), g.values[a].end());
  };
  QuantisedSplats splats;
  splats.degree = g.degree;
  splats.antialiased = g.antialiased;
  splats.position = copied(kPosition);
  splats.rotation = UnitRotations(g);
  splats.scale_log = copied(kScaleLog);
  splats.opacity_logit = copied(kOpacityLogit);
  splats.color_dc = copied(kColorDc);
  for (size_t i = 0; i < n; ++i) splats.own_degree.push_back(uint8_t(HighestBand(g, i)));
  const size_t kept = std::min(n, size_t(std::lround(settings.keep * double(n))));
  const std::vector<float> finite = FiniteOrZero(significance);
  splats.quantised = LeastSignificant(finite, n - kept);
  // Splats without bands have nothing to quantise.
  for (size_t i = 0; i < n; ++i)
    if (splats.own_degree[i] == 0) splats.quantised[i] = 0;
  const std::vector<float> weights = WeightsOf(finite);
  for (int degree = 1; degree <= g.degree; ++degree)
    splats.bands[degree] = BandsOfDegree(g, splats, degree, weights, settings);
  return splats;
}

}  // namespace cosplat

#include "splat/io/kmeans.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "splat/base/rng.h"

namespace cosplat {
namespace {

struct Rows {
  Buffer<float> values;  // [N, width]
  Buffer<float> weight;  // [N]
};

// `count` distinct numbers of 0 .. n - 1, ascending.
std::vector<uint32_t> Draw(size_t count, size_t n, Rng& rng) {
  std::vector<uint32_t> all(n);
  std::iota(all.begin(), all.end(), 0u);
  for (size_t i = 0; i < count; ++i) std::swap(all[i], all[i + rng.Below(n - i)]);
  all.resize(count);
  std::sort(all.begin(), all.end());
  return all;
}

Rows SelectRows(View<const float> rows,
                size_t width,
                View<const float> weight,
                const std::vector<uint32_t>& taken) {
  Rows out;
  for (const uint32_t i : taken) {
    out.values.append(rows.data + i * width, rows.data + (i + 1) * width);
    out.weight.push_back(weight[i]);
  }
  return out;
}

// `count` distinct indices of `weight`, drawn one after the other, each with probability
// proportional to its weight among the remaining ones (Efraimidis & Spirakis 2006).
std::vector<uint32_t> DrawByWeight(size_t count, View<const float> weight, Rng& rng) {
  std::vector<std::pair<double, uint32_t>> order;
  for (uint32_t i = 0; i < weight.size(); ++i)
    order.emplace_back(-std::log(1.0 - double(rng.Uniform())) / double(weight[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<uint32_t> drawn;
  for (size_t i = 0; i < count; ++i) drawn.push_back(order[i].second);
  return drawn;
}

// Moves each centre without rows to a different one of the worst represented rows.
void MoveEmpty(View<const float> rows,
               size_t width,
               View<const float> weight,
               const std::vector<NearestRow>& nearest,
               const std::vector<uint32_t>& empty,
               Buffer<float>& centers) {
  std::vector<uint32_t> worst(nearest.size());
  std::iota(worst.begin(), worst.end(), 0u);
  const auto error = [&](uint32_t i) { return weight[i] * nearest[i].distance2; };
  const size_t count = std::min(empty.size(), worst.size());
  std::partial_sort(
      worst.begin(),
      worst.begin() + std::ptrdiff_t(count),
      worst.end(),
      [&](uint32_t a, uint32_t b) { return error(a) != error(b) ? error(a) > error(b) : a < b; });
  for (size_t i = 0; i < count; ++i)
    std::copy_n(rows.data + worst[i] * width, width, centers.data() + empty[i] * width);
}

// Each centre becomes the mean of its rows.
void MoveToMeans(View<const float> rows,
                 size_t width,
                 View<const float> weight,
                 const std::vector<NearestRow>& nearest,
                 Buffer<float>& centers) {
  std::vector<double> sums(centers.size(), 0), weights(centers.size() / width, 0);
  for (size_t i = 0; i < nearest.size(); ++i) {
    weights[nearest[i].index] += weight[i];
    double* sum = &sums[nearest[i].index * width];
    for (size_t k = 0; k < width; ++k) sum[k] += double(weight[i]) * rows[i * width + k];
  }
  std::vector<uint32_t> empty;
  for (size_t c = 0; c < weights.size(); ++c) {
    if (weights[c] == 0) empty.push_back(uint32_t(c));
    for (size_t k = 0; k < width && weights[c] > 0; ++k)
      centers[c * width + k] = float(sums[c * width + k] / weights[c]);
  }
  if (!empty.empty()) MoveEmpty(rows, width, weight, nearest, empty, centers);
}

}  // namespace

Clusters KMeans(View<const float> rows,
                size_t width,
                View<const float> weight,
                const KMeansSettings& settings) {
  const size_t n = weight.size();
  Clusters clusters;
  if (n == 0) return clusters;
  Rng rng{settings.seed};
  const Rows sample = SelectRows(rows, width, weight, Draw(std::min(settings.sample, n), n, rng));
  const size_t centers = std::min(settings.centers, sample.weight.size());
  const std::vector<uint32_t> first = DrawByWeight(centers, sample.weight, rng);
  clusters.centers = SelectRows(sample.values, width, sample.weight, first).values;
  std::vector<NearestRow> nearest(sample.weight.size());
  for (int i = 0; i < settings.iterations; ++i) {
    FindNearestRows(sample.values, clusters.centers, width, nearest);
    MoveToMeans(sample.values, width, sample.weight, nearest, clusters.centers);
  }
  nearest.resize(n);
  FindNearestRows(rows, clusters.centers, width, nearest);
  MoveToMeans(rows, width, weight, nearest, clusters.centers);
  FindNearestRows(rows, clusters.centers, width, nearest);
  for (const NearestRow& row : nearest) clusters.nearest.push_back(row.index);
  return clusters;
}

}  // namespace cosplat

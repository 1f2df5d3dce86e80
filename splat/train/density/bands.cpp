#include "splat/train/density/bands.h"

#include <algorithm>
#include <cmath>

#include "splat/basis_constants.h"

namespace cosplat {
namespace {

constexpr size_t kFramesWeighed = 50;  // at most, evenly spread
constexpr size_t kFramesJudged = 20;   // likewise

// Squared changes of the images, summed over their pixels, if a Gaussian is cut to each degree.
using CutErrors = std::array<double, kMaxTrainedDegree + 1>;

// A pixel changes by alpha T times the change of the colour; alpha is at most the opacity. On
// trained scenes the changes of one pixel's Gaussians add up as if they were independent
// (docs/dcsh.md).
CutErrors ErrorsOf(const Gaussians& g, size_t i, double weight) {
  const double opacity = 1 / (1 + std::exp(-double(*g.at(kOpacityLogit, i))));
  CutErrors errors{};
  for (int degree = g.degree - 1; degree >= 0; --degree) {
    const double energy = BandEnergy(g, i, degree + 1);
    errors[degree] = errors[degree + 1] + weight * opacity * energy * energy;
  }
  return errors;
}

// The degree, at most `highest`, with the least error plus `price` per coefficient. A NaN error
// never compares as less.
int CheapestDegree(const CutErrors& errors, int highest, double price) {
  int cheapest = highest;
  const auto cost = [&](int degree) { return errors[degree] + price * CoefficientCount(degree); };
  for (int degree = highest - 1; degree >= 0; --degree)
    if (cost(degree) < cost(cheapest)) cheapest = degree;
  return cheapest;
}

// The highest price, to within a relative 1e-6, at which the errors add up to at most `allowed`.
double HighestPrice(const std::vector<CutErrors>& errors,
                    View<const uint8_t> highest,
                    double allowed) {
  double low = -100, high = 100;  // log2 of the price
  while (high - low > 1e-6) {
    const double middle = (low + high) / 2, price = std::exp2(middle);
    double sum = 0;
    for (size_t i = 0; i < errors.size(); ++i) {
      const int degree = CheapestDegree(errors[i], highest[i], price);
      if (degree < highest[i]) sum += errors[i][degree];
    }
    (sum <= allowed ? low : high) = middle;
  }
  return std::exp2(low);
}

}  // namespace

float BandEnergy(const Gaussians& g, size_t i, int band) {
  const float *constants = BasisConstants(g.basis), *orthonormal = BasisConstants(Basis::kSh);
  const float* rest = g.at(kColorRest, i);
  double sum = 0;
  for (int k = CoefficientCount(band - 1); k < CoefficientCount(band); ++k) {
    const double scale = double(constants[k]) / orthonormal[k];
    for (int c = 0; c < 3; ++c) {
      const double x = scale * rest[3 * (k - 1) + c];
      sum += x * x;
    }
  }
  return float(std::sqrt(sum / (3 * 4 * internal::kPi)));
}

void DropBands(const Weights& weights, float threshold, Gaussians& g) {
  if (g.degrees.empty()) g.degrees.assign(g.size(), uint8_t(g.degree));
  std::vector<CutErrors> errors;
  double covered = 0;  // pixels
  for (size_t i = 0; i < g.size(); ++i) {
    errors.push_back(ErrorsOf(g, i, weights[i]));
    covered += weights[i];
  }
  const double price = HighestPrice(errors, g.degrees, double(threshold) * threshold * covered);
  for (size_t i = 0; i < g.size(); ++i)
    g.degrees[i] = uint8_t(CheapestDegree(errors[i], g.degrees[i], price));
  ZeroAbove(g.degrees, g);
}

void ZeroAbove(View<const uint8_t> degrees, Gaussians& of) {
  const int width = of.width(kColorRest);
  for (size_t i = 0; i < degrees.size(); ++i) {
    float* rest = of.at(kColorRest, i);
    std::fill(rest + 3 * (CoefficientCount(degrees[i]) - 1), rest + width, 0.0f);
  }
}

DegreeCounts CountDegrees(const Gaussians& g) {
  DegreeCounts counts{};
  if (g.degrees.empty()) counts[g.degree] = g.size();
  for (const uint8_t degree : g.degrees) ++counts[degree];
  return counts;
}

DegreeFigures FiguresOf(const DegreeCounts& counts, int degree) {
  double gaussians = 0, degrees = 0, coefficients = 0;
  for (int d = 0; d <= degree; ++d) {
    gaussians += double(counts[d]);
    degrees += d * double(counts[d]);
    coefficients += (CoefficientCount(d) - 1) * double(counts[d]);
  }
  if (gaussians == 0 || degree == 0) return {};
  return {degrees / gaussians, 1 - coefficients / (gaussians * (CoefficientCount(degree) - 1))};
}

bool BandSchedule::DropsAt(int iteration, int iterations) {
  const int64_t last_third = iterations / 3;
  for (int round = 0; round < kRounds; ++round)
    if (iteration == iterations - last_third * round / (kRounds - 1)) return true;
  return false;
}

double DropBandsInTraining(float threshold,
                           FrameImages& images,
                           View<const uint32_t> frames,
                           const std::array<float, 3>& background,
                           Gaussians& gaussians,
                           const std::function<void()>& changed) {
  const FrameChoice judged{frames, gaussians.degree, background, kFramesJudged};
  const FrameChoice weighed{frames, gaussians.degree, background, kFramesWeighed};
  const double before = images.ErrorIn(judged).mean_psnr;
  Weights weights;
  for (const Contribution& c : images.Contributions(weighed)) weights.push_back(c.weight);
  // The squares of independent changes add up.
  DropBands(weights, threshold / std::sqrt(float(BandSchedule::kRounds)), gaussians);
  changed();
  return images.ErrorIn(judged).mean_psnr - before;
}

}  // namespace cosplat

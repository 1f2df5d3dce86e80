#include "apps/study/stability/basis_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "apps/study/bench/measure.h"
#include "apps/study/stability/basis_samples.h"
#include "apps/study/stability/stability_case.h"
#include "splat/base/rng.h"
#include "splat/basis_constants.h"
#include "splat/device/buffer.h"

namespace cosplat {
namespace {

constexpr int kCount = BasisSamples::kCount, kStride = BasisSamples::kStride;
constexpr int kNumbers = 3 * kMaxCoefficients;

struct SampleSet {
  std::vector<ExactDirection> exact;  // [kCount]; rounded to float for the evaluation
  Buffer<float> x, y, z, coefficients;
  Buffer<uint16_t> halves;

  explicit SampleSet(uint64_t seed)
      : x(kCount), y(kCount), z(kCount), coefficients(kNumbers * kStride), halves(x.size()) {
    Rng rng{seed};
    for (int i = 0; i < kCount; ++i) {
      // A quarter of them between 1e-6 rad and 1 rad from a pole, the others uniform on the sphere.
      const double t = rng.Uniform(), turn = 2 * M_PI * rng.Uniform();
      const double polar = i % 4 ? std::acos(1 - 2 * t) : std::pow(10.0, -6 * t);
      exact.push_back(DirectionAt(i % 8 == 4 ? M_PI - polar : polar, turn));
      x[i] = float(exact[i].x);
      y[i] = float(exact[i].y);
      z[i] = float(exact[i].z);
    }
    // Colours around 0.8, rarely clamped to 0, which would hide errors.
    for (int k = 0; k < kNumbers; ++k)
      for (int i = 0; i < kStride; ++i)
        coefficients[k * kStride + i] = (k < 3 ? 1.0f : 0.0f) + 0.05f * rng.Normal();
    halves.resize(coefficients.size());
    RoundToHalves(coefficients.data(), halves.data(), int(halves.size()));
  }
  BasisSamples View() const {
    return {x.data(), y.data(), z.data(), coefficients.data(), halves.data()};
  }
};

double LargestError(const SampleSet& set, int degree, const Buffer<float>& out) {
  double largest = 0;
  for (int i = 0; i < kCount; ++i) {
    const ExactBasis basis = ExactBasisAt(set.exact[i]);
    for (int c = 0; c < 3; ++c) {
      long double color = 0.5L;
      for (int k = 0; k < CoefficientCount(degree); ++k)
        color += basis[k] * set.coefficients[(3 * k + c) * kStride + i];
      largest = LargerError(largest, double(std::abs(out[c * kCount + i] - std::max(color, 0.0L))));
    }
  }
  return largest;
}

using Evaluate = std::function<void(int degree, const BasisSamples& samples, float* out)>;

BasisForm Measure(const std::string& name,
                  const std::vector<SampleSet>& sets,
                  int batches,
                  const Evaluate& evaluate) {
  constexpr int kCalls = 8;  // a batch takes about 20 to 200 microseconds
  BasisForm form{name, {}};
  Buffer<float> out(3 * kCount);
  for (int degree = 0; degree <= kMaxEvaluatedDegree; ++degree) {
    BasisFormPoint point{degree, 0, 0};
    for (const SampleSet& set : sets) {
      evaluate(degree, set.View(), out.data());
      point.error = LargerError(point.error, LargestError(set, degree, out));
    }
    const BasisSamples samples = sets[0].View();
    if (batches > 0)
      point.ns = 1e9 / kCount *
                 FastestSeconds(batches, kCalls, [&] { evaluate(degree, samples, out.data()); });
    form.points.push_back(point);
  }
  return form;
}

}  // namespace

std::vector<BasisForm> MeasureBasisForms(int batches) {
  constexpr uint64_t kSets = 8;
  std::vector<SampleSet> sets;
  for (uint64_t seed = 1; seed <= kSets; ++seed) sets.emplace_back(seed);
  const auto on = [](auto function, BasisWay way) {
    return [=](int degree, const BasisSamples& samples, float* out) {
      function(way, degree, samples, out);
    };
  };
  const auto floats = [&](const char* name, BasisWay way) {
    return Measure(name, sets, batches, on(EvaluateOnFloats, way));
  };
  const auto packs = [&](const char* name, BasisWay way) {
    return Measure(name, sets, batches, on(EvaluateOnPacks, way));
  };
  return {floats("arctan(y/x), float", BasisWay::kLiteral),
          packs("arctan(y/x), SIMD", BasisWay::kLiteral),
          floats("acos, atan2, float", BasisWay::kTextbook),
          packs("acos, atan2, SIMD", BasisWay::kTextbook),
          floats("polynomials, float", BasisWay::kPolynomials),
          packs("polynomials, SIMD", BasisWay::kPolynomials),
          Measure("polynomials, SIMD, half", sets, batches, EvaluateFromHalves)};
}

}  // namespace cosplat

#include "splat/gaussians.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "splat/base/error.h"
#include "splat/basis_constants.h"
#include "splat/device/arrays.h"
#include "splat/math/gaussian.h"

namespace cosplat {

Basis BasisFromString(const std::string& text, const std::string& file, const std::string& field) {
  std::string known;
  for (size_t i = 0; i < kBasisNames.size(); ++i) {
    if (text == kBasisNames[i]) return Basis(i);
    known += (i > 0 ? ", " : "") + std::string(kBasisNames[i]);
  }
  throw Error(file, field, "'" + text + "' is not a basis; known: " + known);
}

int Gaussians::width(int attribute) const {
  constexpr std::array<int, kAttributeCount> kWidths{3, 4, 3, 1, 3, 0, 0};
  if (attribute == kColorRest) return 3 * (CoefficientCount(degree) - 1);
  if (attribute == kCorrection) return kCorrectionNumbers * corrections;
  return kWidths[attribute];
}

void Gaussians::Resize(size_t n) {
  for (int a = 0; a < kAttributeCount; ++a) values[a].resize(n * width(a), 0.0f);
  if (!degrees.empty()) degrees.resize(n, uint8_t(degree));
  if (!smoothing.empty()) smoothing.resize(n, 0.0f);
}

void Gaussians::Gather(const std::vector<uint32_t>& source) {
  ForEachArray(
      [&](const std::string&, size_t w, auto& array) {
        if (array.empty()) return;
        std::decay_t<decltype(array)> gathered(source.size() * w);
        for (size_t i = 0; i < source.size(); ++i)
          for (size_t k = 0; k < w; ++k) gathered[i * w + k] = array[source[i] * w + k];
        array = std::move(gathered);
      },
      *this);
}

void Gaussians::Append(const Gaussians& more) {
  ForEachArray(
      [](const std::string&, size_t, auto& to, const auto& from) {
        to.append(from.begin(), from.end());
      },
      *this,
      more);
}

Gaussians Gaussians::ZerosLike(size_t n) const {
  Gaussians zeros;
  zeros.degree = degree;
  zeros.basis = basis;
  zeros.corrections = corrections;
  zeros.Resize(n);
  return zeros;
}

void Gaussians::TakeLayout(const Gaussians& from) {
  degree = from.degree;
  basis = from.basis;
  corrections = from.corrections;
  antialiased = from.antialiased;
  low_pass_variance = from.low_pass_variance;
}

void Gaussians::Upload(const Gaussians& from, Stream& stream) {
  TakeLayout(from);
  UploadArrays(from, *this, stream);
}

void Gaussians::Download(Gaussians& to, Stream& stream) const {
  to.TakeLayout(*this);
  DownloadArrays(*this, to, stream);
}

void Gaussians::RefillLike(const Gaussians& other, Stream& stream, size_t n) {
  degree = other.degree;
  basis = other.basis;
  corrections = other.corrections;
  degrees.clear();
  for (int a = 0; a < kAttributeCount; ++a) values[a].Refill(n * size_t(width(a)), stream);
}

void Gaussians::FillWithZeros(Stream& stream) {
  for (Buffer<float>& v : values) v.FillWithZeros(stream);
}

int HighestBand(const Gaussians& g, size_t i) {
  const float* rest = g.at(kColorRest, i);
  int used = g.width(kColorRest);
  while (used > 0 && rest[used - 1] == 0) --used;
  int degree = 0;
  while (3 * (CoefficientCount(degree) - 1) < used) ++degree;
  return degree;
}

void FindDegrees(Gaussians& g) {
  g.degrees.resize(g.size());
  bool all = true;
  for (size_t i = 0; i < g.size(); ++i) {
    g.degrees[i] = uint8_t(HighestBand(g, i));
    all = all && g.degrees[i] == g.degree;
  }
  if (all) g.degrees.clear();
}

void ConvertBasis(Gaussians& g, Basis to) {
  if (g.basis == to) return;
  if (!IsHarmonic(g.basis, g.degree) || !IsHarmonic(to, g.degree))
    throw Error(
        "basis",
        ToString(Basis::kDcshLiteral) +
            " folds the viewing direction, so it cannot be converted to spherical harmonics "
            "for other programs");
  const float* from_constants = BasisConstants(g.basis);
  const float* to_constants = BasisConstants(to);
  const int rest = CoefficientCount(g.degree) - 1;
  for (size_t i = 0; i < g.size(); ++i)
    for (int k = 1; k <= rest; ++k) {
      const float factor = from_constants[k] / to_constants[k];
      for (int c = 0; c < 3; ++c) g.at(kColorRest, i)[3 * (k - 1) + c] *= factor;
    }
  g.basis = to;
}

void BakeSmoothing(Gaussians& g) {
  // Smaller opacities than any renderer draws, but their logit is finite.
  constexpr float kMinOpacity = 1e-20f;
  for (size_t i = 0; i < g.smoothing.size(); ++i) {
    float* s = g.at(kScaleLog, i);
    const auto smoothed = math::SmoothScale(
        math::Vec3<float>{std::exp(s[0]), std::exp(s[1]), std::exp(s[2])}, g.smoothing[i]);
    s[0] = std::log(smoothed.scale.x);
    s[1] = std::log(smoothed.scale.y);
    s[2] = std::log(smoothed.scale.z);
    float& logit = *g.at(kOpacityLogit, i);
    logit = math::Logit(std::max(math::Sigmoid(logit) * smoothed.share, kMinOpacity));
  }
  g.smoothing.clear();
}

void MoveOrigin(Gaussians& g, const WorldOrigin& to) {
  for (size_t k = 0; k < 3; ++k) {
    const double shift = g.origin[k] - to[k];
    if (shift == 0) continue;
    for (size_t i = 0; i < g.size(); ++i)
      g.at(kPosition, i)[k] = float(double(g.at(kPosition, i)[k]) + shift);
  }
  g.origin = to;
}

bool IsRoundedFarAway(const Gaussians& g) {
  if (g.origin == WorldOrigin{}) return false;
  for (size_t i = 0; i < g.values[kPosition].size(); ++i) {
    const double in_world = double(g.values[kPosition][i]) + g.origin[i % 3];
    if (double(float(in_world)) != in_world) return false;
  }
  return true;
}

size_t AllocatedBytes(const Gaussians& gaussians) { return AllocatedByArrays(gaussians); }

std::vector<uint32_t> SortByDegree(Gaussians& g) {
  FindDegrees(g);
  std::vector<uint32_t> order;
  for (int degree = 0; degree <= g.degree; ++degree)
    for (size_t i = 0; i < g.degrees.size(); ++i)
      if (g.degrees[i] == degree) order.push_back(uint32_t(i));
  if (!order.empty()) g.Gather(order);
  return order;
}

}  // namespace cosplat

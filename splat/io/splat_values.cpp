#include "splat/io/splat_values.h"

#include <algorithm>
#include <array>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/config.h"

namespace cosplat {
namespace {

double NormOf(const float* q) {
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += double(q[k]) * q[k];
  return std::sqrt(sum);
}

// Whether the renderer does not draw a Gaussian with this quaternion. False for NaN.
bool HasNoDirection(const float* q) {
  const double norm = NormOf(q);
  return norm * norm <= kMinQuaternionNorm2;
}

// Squares as floats lose those that are much shorter or longer.
void SettleRotation(float* q) {
  constexpr double kShort = 1e-3, kLong = 1e15;
  constexpr double kZero = 1e-12;  // below it torch.nn.functional.normalize, hence 3DGS, does not
  const double norm = NormOf(q);
  if ((norm >= kShort && norm <= kLong) || norm < kZero) return;
  for (int k = 0; k < 4; ++k) q[k] = float(q[k] / norm);
}

std::string CountOf(size_t count, const std::string& of_what) {
  return std::to_string(count) + " " + of_what;
}

}  // namespace

void SettleSplats(Gaussians& g, std::vector<std::string>* notes) {
  size_t opacities = 0, points = 0;
  for (float& logit : g.values[kOpacityLogit]) {
    if (std::isfinite(logit)) continue;
    logit = std::copysign(kOpaqueLogit, logit);
    ++opacities;
  }
  for (float& scale : g.values[kScaleLog]) {
    points += std::isinf(scale);
    scale = std::max(scale, -kLargestScaleLog);
  }
  for (size_t i = 0; i < g.size(); ++i) SettleRotation(g.at(kRotation, i));
  if (notes && opacities > 0)
    notes->push_back(CountOf(opacities, "opacities are infinite: drawn as opaque or transparent"));
  if (notes && points > 0)
    notes->push_back(CountOf(points, "scales are 0: drawn as thin as they can be"));
}

void NoteOtherUnits(const Gaussians& g, std::vector<std::string>& notes) {
  constexpr size_t kEnough = 100;  // fewer may be so by chance
  if (g.size() < kEnough) return;
  struct Range {
    float low, high;
    explicit Range(const Buffer<float>& values) {
      const auto [first, last] = std::minmax_element(values.begin(), values.end());
      low = *first, high = *last;
    }
    bool IsWithin(float from, float to) const { return low >= from && high <= to; }
  };
  const Range opacity(g.values[kOpacityLogit]), scale(g.values[kScaleLog]),
      color(g.values[kColorDc]), position(g.values[kPosition]);
  constexpr float kBytes = 30;  // no logit and no colour of a trained scene is so large
  if (opacity.IsWithin(0, 1) || (opacity.low >= 0 && opacity.high > kBytes))
    notes.push_back(Format("opacities are from {:.3g} to {:.3g}: are they logits, as 3DGS's?",
                           opacity.low,
                           opacity.high));
  constexpr float kSmallScene = 100;
  if (scale.low >= 0 && position.high - position.low < kSmallScene)
    notes.push_back("all sizes are above 1: are the scales logarithms, as 3DGS's?");
  if (color.IsWithin(0, 1) || (color.low >= 0 && color.high > kBytes))
    notes.push_back(Format("colours are from {:.3g} to {:.3g}: are they coefficients, as 3DGS's?",
                           color.low,
                           color.high));
}

void LeaveOutUndrawable(const std::string& path, Gaussians& g, std::vector<std::string>* notes) {
  size_t without_rotation = 0, too_large = 0;
  std::vector<uint32_t> kept;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* scale = g.at(kScaleLog, i);
    const bool large = *std::max_element(scale, scale + 3) > kLargestScaleLog;
    const bool undirected = HasNoDirection(g.at(kRotation, i));
    without_rotation += undirected;
    too_large += large && !undirected;
    if (!large && !undirected) kept.push_back(uint32_t(i));
  }
  const size_t left_out = g.size() - kept.size();
  if (left_out == 0) return;
  std::string why;
  if (without_rotation > 0) why += CountOf(without_rotation, "have a quaternion of zero");
  if (too_large > 0) why += (why.empty() ? "" : ", ") + CountOf(too_large, "are of infinite size");
  const std::string of_all = " of " + std::to_string(g.size()) + " splats cannot be drawn";
  if (kept.empty()) throw Error(path, "all" + of_all + ": " + why);
  if (notes) notes->push_back(std::to_string(left_out) + of_all + " and are left out: " + why);
  g.Gather(kept);
}

void HideWithoutRotation(float* rotation, float& opacity_logit) {
  constexpr std::array<float, 4> kNoTurn{1, 0, 0, 0};
  if (!HasNoDirection(rotation)) return;
  std::copy(kNoTurn.begin(), kNoTurn.end(), rotation);
  opacity_logit = -kOpaqueLogit;
}

void HideWithoutRotation(Gaussians& g) {
  for (size_t i = 0; i < g.size(); ++i)
    HideWithoutRotation(g.at(kRotation, i), *g.at(kOpacityLogit, i));
}

double LowPassNumber(const Gaussians& g) {
  return g.low_pass_variance == kBlurVariance ? 0.3 : 0.1;
}

void SetAntialiased(const std::string& path, double variance, Gaussians& g) {
  g.antialiased = true;
  for (const float known : {kAntialiasedBlurVariance, kBlurVariance})
    if (std::abs(variance - known) < 1e-6) {
      g.low_pass_variance = known;
      return;
    }
  throw Error(path, kLowPassField, "is " + std::to_string(variance) + ", expected 0.1 or 0.3");
}

}  // namespace cosplat

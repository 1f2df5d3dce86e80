// The stability cases of blending: opacity, the last splat of a pixel, order.
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include "apps/study/stability/cases.h"
#include "apps/study/stability/image.h"
#include "apps/study/stability/naive_render.h"
#include "apps/study/stability/test_scene.h"
#include "splat/base/rng.h"
#include "splat/basis_constants.h"
#include "splat/math/blend.h"

namespace cosplat {
namespace {

using Vec3 = math::Vec3<float>;

// `count` opaque Gaussians at one point. In floats, the sigmoid of their logit is 1.
Gaussians Coincident(size_t count) {
  Gaussians g;
  for (size_t i = 0; i < count; ++i) Append({{0, 0, 2}, 0.3f, 0.5f, {0.8f, 0.5f, 0.2f}}, g);
  for (float& logit : g.values[kOpacityLogit]) logit = 20;
  return g;
}

// d(pixel) / d(alpha of the first) of 1000 splats with equal alpha, without opacity cap or early
// stop, as in 3DGS's equations.
struct PixelGradient {
  size_t not_finite = 0;
  float first = 0;
};
PixelGradient UncappedGradient(float alpha, size_t count) {
  const Vec3 color{0.8f, 0.5f, 0.2f}, d_pixel{1, 1, 1};
  math::BlendState<float> drawn{1, {0, 0, 0}};
  for (size_t i = 0; i < count; ++i) math::BlendBehind(alpha, color, drawn);
  math::BlendVjpState<float> state{1, math::Dot(drawn.color, d_pixel)};
  PixelGradient result;
  for (size_t i = 0; i < count; ++i) {
    const float d_alpha = math::BlendBehindVjp(alpha, color, d_pixel, state).d_alpha;
    result.not_finite += !std::isfinite(d_alpha);
    if (i == 0) result.first = d_alpha;
  }
  return result;
}

// Grey image of the gradient's magnitude over a splat, with its centre in the middle cell; black
// for 0, white for 1 and above.
template <class F>
Image8 GradientImage(const F& gradient) {
  constexpr int kCells = 19, kCell = 8, kMiddle = kCells / 2;
  return Paint(kCells * kCell, kCells * kCell, [&](int x, int y) {
    const float dx = float(x / kCell - kMiddle), dy = float(y / kCell - kMiddle);
    const float g = gradient(std::exp(-(dx * dx + dy * dy) / (2 * 3.5f * 3.5f)));
    return Vec3{std::abs(g), std::abs(g), std::abs(g)};
  });
}

// Six splats of alpha 0.93 over the whole image: after three, the transmittance is 4e-4; the fourth
// brings it below the limit and is the last contributor.
Gaussians Stack() {
  Gaussians g;
  for (int i = 0; i < 6; ++i)
    Append({{0, 0, 3 + 0.01f * float(i)}, 10, 0.93f, {0.2f + 0.1f * float(i), 0.5f, 0.9f}}, g);
  return g;
}
constexpr size_t kLast = 3;

// dL/d(red of the last contributor) by a backward pass that stops where the next alpha would bring
// the transmittance below the limit, although the forward pass blended that splat.
double GradientStoppingEarlier(const Gaussians& g, const Camera& camera) {
  const std::vector<NaiveFootprint> footprints = NaiveFootprints(g, camera);
  double sum = 0;
  for (int i = 0; i < camera.width * camera.height; ++i) {
    float transmittance = 1;
    for (size_t k = 0; k < footprints.size(); ++k) {
      const float weight = footprints[k].opacity * transmittance;
      if (transmittance - weight < kMinTransmittance) break;
      if (k == kLast) sum += double(weight) * double(PixelWeight(size_t(i)));
      transmittance -= weight;
    }
  }
  return sum * double(BasisConstants(g.basis)[0]);
}

// dL/d(red of the last contributor) by finite differences, which reflect the forward pass.
double NumericGradient(Gaussians g, const Camera& camera) {
  constexpr float kStep = 0.25f;
  g.at(kColorDc, kLast)[0] += kStep;
  const double up = WeighedSum(Draw(g, camera));
  g.at(kColorDc, kLast)[0] -= 2 * kStep;
  return (up - WeighedSum(Draw(g, camera))) / (2 * double(kStep));
}

// Change of an image caused by a different order alone; the largest of several is kept.
struct Change {
  double levels = -1;  // root mean square, of 255
  Image8 image;        // 8 times brighter

  void Take(const Image& now, const Image& in_old_order) {
    double square = 0;
    for (size_t i = 0; i < now.data.size(); ++i)
      square += std::pow(double(now.data[i] - in_old_order.data[i]), 2);
    const double apart = LargerError(0, 255 * std::sqrt(square / double(now.data.size())));
    if (apart <= levels) return;
    levels = apart;
    Image difference = now;
    for (size_t i = 0; i < now.data.size(); ++i)
      difference.data[i] = 8 * std::abs(now.data[i] - in_old_order.data[i]);
    image = ImageOf(difference);
  }
};

// Addends like the gradients of a splat from many tiles: of either sign and many magnitudes.
std::vector<float> ManyRecords() {
  Rng rng{3};
  std::vector<float> records(2000);
  for (float& r : records) r = rng.Normal() * std::exp(3 * rng.Normal());
  return records;
}

std::string BitsOf(const Gaussians& g) {
  std::string bits;
  for (const auto& values : g.values)
    bits.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  return bits;
}

}  // namespace

StabilityCase OpacitySaturation() {
  constexpr size_t kCount = 1000;
  StabilityCase s;
  s.key = "opacity_saturation";
  s.title = "A thousand opaque Gaussians in one place";
  s.what =
      "The gradient of what lies behind is divided by 1 - alpha, which is 0 where an opaque one "
      "is at its centre. The image: the gradient of the first one's alpha over its footprint.";
  s.quantity = "gradients of 1000 that are not finite";
  const Gaussians g = Coincident(kCount);
  const Gaussians gradients = DrawBothWays(g, StraightCamera(33)).gradients;
  size_t broken = 0;
  for (size_t i = 0; i < kCount; ++i) broken += !std::isfinite(*gradients.at(kOpacityLogit, i));
  s.naive = {"alpha up to 1",
             double(UncappedGradient(1, kCount).not_finite),
             GradientImage([](float falloff) { return UncappedGradient(falloff, 8).first; })};
  s.ours = {"alpha up to 0.99, stop at 1e-4",
            double(std::max(broken, CountNotFinite(gradients))),
            GradientImage([](float falloff) {
              const float alpha = math::AlphaOf(1.0f, falloff);
              return math::AlphaOfVjp(1.0f, falloff, UncappedGradient(alpha, 8).first);
            })};
  s.bound = 0;
  return s;
}

StabilityCase LastContributor() {
  const Camera camera = StraightCamera(16);
  const Gaussians g = Stack();
  StabilityCase s;
  s.key = "last_contributor";
  s.title = "The last Gaussian of a pixel";
  s.what =
      "A pixel that is opaque stops. Where the backward pass stops one Gaussian earlier than the "
      "forward pass drew, the last one is seen and never learns.";
  s.quantity = "error of the last one's gradient against differences";
  s.unit = "percent";
  const double numeric = NumericGradient(g, camera);
  const double ours = DrawBothWays(g, camera).gradients.at(kColorDc, kLast)[0];
  const double naive = GradientStoppingEarlier(g, camera);
  s.naive = {"stops before it", 100 * std::abs(naive / numeric - 1), {}};
  s.ours = {"one rule for both passes", 100 * std::abs(ours / numeric - 1), {}};
  s.bound = 0.5;  // differences of sums of 768 floats
  return s;
}

StabilityCase Popping() {
  constexpr int kFrames = 20, kSide = 80;
  constexpr double kStep = 0.1 * M_PI / 180, kStale = 4 * M_PI / 180;
  const Gaussians g = RandomBlobs(1500, 2.5f, 11, 0.05f);
  const auto seen_at = [&](double rad) {
    return NaiveFootprints(g, Turned(StraightCamera(kSide), rad));
  };
  const auto drawn = [&](const std::vector<NaiveFootprint>& f, const std::vector<uint32_t>& order) {
    return DrawNaive(f, order, kSide, kSide);
  };
  Change naive, ours;
  const std::vector<NaiveFootprint> before = seen_at(-kStale), after = seen_at(kStale);
  naive.Take(drawn(after, DepthOrder(after)), drawn(after, DepthOrder(before)));
  std::vector<uint32_t> last = DepthOrder(seen_at(-0.5 * kFrames * kStep));
  for (int frame = 1; frame <= kFrames; ++frame) {
    const double rad = kStep * (frame - 0.5 * kFrames);
    const std::vector<NaiveFootprint> footprints = seen_at(rad);
    ours.Take(Draw(g, Turned(StraightCamera(kSide), rad)).ToImage(), drawn(footprints, last));
    last = DepthOrder(footprints);
  }
  StabilityCase s;
  s.key = "popping";
  s.title = "Popping";
  s.what =
      "Gaussians have one depth each, so that two of them change places at once as the camera "
      "turns, here by 0.1 degree a frame: what changing the order alone does, 8 times brighter in "
      "the images. Ours pops, too, by this much: nothing sorts per pixel.";
  s.quantity = "largest change of a frame, root mean square over its pixels";
  s.unit = "levels of 255";
  s.naive = {"order kept until the camera has turned by 8 degrees", naive.levels, naive.image};
  s.ours = {"sorted in every frame", ours.levels, ours.image};
  s.bound = 1.5;
  return s;
}

StabilityCase SumOrder() {
  constexpr int kRuns = 64;
  StabilityCase s;
  s.key = "sum_order";
  s.title = "Sums in the order in which threads arrive";
  s.what =
      "Floating-point addition depends on its order, and atomics add in any: the same gradient of "
      "2000 parts added in 64 orders, against a whole backward pass with 1 to 4 threads.";
  s.quantity = "different results of one sum";
  std::vector<float> records = ManyRecords();
  Rng rng{5};
  std::set<float> sums;
  for (int run = 0; run < kRuns; ++run) {
    for (size_t i = records.size() - 1; i > 0; --i)
      std::swap(records[i], records[rng.Below(i + 1)]);
    float sum = 0;
    for (const float r : records) sum += r;
    sums.insert(sum);
  }
  const Gaussians g = RandomBlobs(200, 2.5f, 13);
  std::set<std::string> gradients;
  for (int run = 0; run < 8; ++run) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    size_t(1 + run % 4));
    gradients.insert(BitsOf(DrawBothWays(g, StraightCamera(64)).gradients));
  }
  s.naive = {"as atomics add", double(sums.size()), {}};
  s.ours = {"in a fixed order", double(gradients.size()), {}};
  s.bound = 1;
  return s;
}

}  // namespace cosplat

#include "splat/media/refine_mattes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "splat/media/image_filters.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr float kSure = 0.96f;  // a network is sure that there is the person above it

constexpr float kCodecNoise = 1.5f / 255;

float SmoothStep(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.f, 1.f);
  return t * t * (3 - 2 * t);
}

float Largest(const float* a, const float* b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

// Where `test` holds of a channel's values.
template <class Test>
Image Where(const Image& image, const Test& test) {
  Image mask(image.width, image.height, 1);
  for (size_t i = 0; i < image.pixels(); ++i) mask.data[i] = test(image.data[i]) ? 1.f : 0.f;
  return mask;
}

// --- 1: what never moves ---

// The person's matte without things that hold still in all frames, where they are seen.
void TakeOut(const Image8& things,
             const Image& frame,
             const StillBackground& still,
             Image8& matte) {
  Image away(frame.width, frame.height, 1);
  for (size_t i = 0; i < away.data.size(); ++i)
    away.data[i] = Largest(&frame.data[3 * i], &still.color.data[3 * i]);
  away = BoxMean(away, 2);
  for (size_t i = 0; i < away.data.size(); ++i)
    if (things.data[i] != 0 && away.data[i] < 4 * still.noise.data[i]) matte.data[i] = 0;
}

// --- 3: by the frame's colours (2 is in face_part.h) ---

struct Radii {
  int rim, window;
  explicit Radii(double network_px)
      : rim(std::max(2, int(std::lround(2 * network_px)))),
        window(std::max(4, int(std::lround(4 * network_px)))) {}
};

// 1 near where the network is not sure.
Image RimOf(const Image& person, int radius) {
  return Dilated(Where(person, [](float a) { return a > kClearMatte && a < kSure; }), radius);
}

constexpr float kEdge = 0.03f;  // contrast, [0, 1]
constexpr int kRounds = 3;
constexpr float kContrast = 1.5f;  // of a round: colours decide, one way or the other

Image GuidedRim(const Image& frame, const Image& person, const Image& rim, const Radii& r) {
  Image result = person;
  for (int round = 0; round < kRounds; ++round) {
    Image weight(frame.width, frame.height, 1);
    for (size_t i = 0; i < weight.data.size(); ++i) {
      const float sure = 2 * result.data[i] - 1;
      weight.data[i] = 0.02f + sure * sure;
    }
    const int window = std::max(3, r.window >> round);
    const Image fit = GuidedFilter(frame, result, weight, window, kEdge * kEdge);
    for (size_t i = 0; i < rim.data.size(); ++i)
      if (rim.data[i] > 0)
        result.data[i] = std::clamp(kContrast * (fit.data[i] - 0.5f) + 0.5f, 0.f, 1.f);
  }
  return result;
}

// --- 4: by the background ---

// Mean colours of a mask's pixels nearby; 4th channel: their share of the window.
Image MeanColor(const Image& frame, const Image& mask, int radius) {
  Image sums(frame.width, frame.height, 4);
  for (size_t i = 0; i < mask.data.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) sums.data[4 * i + c] = mask.data[i] * frame.data[3 * i + c];
    sums.data[4 * i + 3] = mask.data[i];
  }
  sums = BoxMean(sums, radius);
  for (size_t i = 0; i < mask.data.size(); ++i)
    for (size_t c = 0; c < 3; ++c) sums.data[4 * i + c] /= std::max(sums.data[4 * i + 3], 1e-6f);
  return sums;
}

// The background as this frame shows it, and how far it can be trusted.
struct Behind {
  Image color;  // RGB: with the light of this frame
  Image noise;  // 1 channel: its standard deviation
  Image trust;  // 1 channel, 0 to 1: how much of the background nearby is as it was in others
};

// Where no other frame shows the background it is taken to be as this frame has it nearby: little
// is known by that of a pattern, much of a wall.
void ContinueNearby(const Image& frame,
                    const StillBackground& still,
                    const Image& clear,
                    int radius,
                    Behind& behind) {
  Image sums(frame.width, frame.height, 7);
  for (size_t i = 0; i < clear.data.size(); ++i) {
    if (clear.data[i] == 0) continue;
    for (size_t c = 0; c < 3; ++c) {
      const float value = frame.data[3 * i + c];
      sums.data[7 * i + c] = value;
      sums.data[7 * i + 3 + c] = value * value;
    }
    sums.data[7 * i + 6] = 1;
  }
  sums = BoxMean(sums, radius);
  for (size_t i = 0; i < clear.data.size(); ++i) {
    const float share = sums.data[7 * i + 6];
    if (still.noise.data[i] >= 0 || share < 0.02f) continue;
    float spread = 0;
    for (size_t c = 0; c < 3; ++c) {
      const float mean = sums.data[7 * i + c] / share;
      behind.color.data[3 * i + c] = mean;
      spread = std::max(spread, sums.data[7 * i + 3 + c] / share - mean * mean);
    }
    behind.noise.data[i] = kCodecNoise + 2 * std::sqrt(std::max(spread, 0.f));
    behind.trust.data[i] = SmoothStep(0.02f, 0.08f, share);
  }
}

Behind BehindOf(const Image& frame,
                const StillBackground& still,
                const Image& clear,
                const Radii& r) {
  const int radius = 3 * r.window;
  const auto seen = [&](size_t i) { return clear.data[i] > 0 && still.noise.data[i] >= 0; };
  Image light(frame.width, frame.height, 4);  // differences of colours, and the pixels they are of
  for (size_t i = 0; i < clear.data.size(); ++i) {
    if (!seen(i)) continue;
    for (size_t c = 0; c < 3; ++c)
      light.data[4 * i + c] = frame.data[3 * i + c] - still.color.data[3 * i + c];
    light.data[4 * i + 3] = 1;
  }
  light = BoxMean(light, radius);
  Behind behind{still.color, still.noise, Image(frame.width, frame.height, 2)};
  for (size_t i = 0; i < clear.data.size(); ++i) {
    for (size_t c = 0; c < 3; ++c)
      behind.color.data[3 * i + c] +=
          light.data[4 * i + c] / std::max(light.data[4 * i + 3], 1e-3f);
    if (!seen(i)) continue;
    const float d = Largest(&frame.data[3 * i], &behind.color.data[3 * i]);
    behind.trust.data[2 * i] = 1;
    behind.trust.data[2 * i + 1] = d < 4 * still.noise.data[i] ? 1.f : 0.f;
  }
  const Image sums = BoxMean(behind.trust, radius);
  behind.trust = Image(frame.width, frame.height, 1);
  for (size_t i = 0; i < clear.data.size(); ++i)
    behind.trust.data[i] =
        SmoothStep(0.6f, 0.85f, sums.data[2 * i + 1] / std::max(sums.data[2 * i], 1e-3f));
  ContinueNearby(frame, still, clear, radius, behind);
  return behind;
}

struct Difference {
  float alpha, weight;
};

// Of a pixel's colour, a mean of the person's nearby, and the background there.
Difference Compare(const float* color, const float* person, const float* behind, float noise) {
  float along = 0, length = 0;
  for (int c = 0; c < 3; ++c) {
    along += (color[c] - behind[c]) * (person[c] - behind[c]);
    length += (person[c] - behind[c]) * (person[c] - behind[c]);
  }
  const float alpha = std::clamp(along / std::max(length, 1e-6f), 0.f, 1.f);
  float rest = 0;
  for (int c = 0; c < 3; ++c) {
    const float d = color[c] - behind[c] - alpha * (person[c] - behind[c]);
    rest += d * d;
  }
  // Another colour than the mean one, and not between it and the background, is the person's, too.
  const float away = std::sqrt(rest), far = std::sqrt(rest + alpha * alpha * length);
  const float other = SmoothStep(0.35f, 0.7f, away / std::max(far, 1e-3f)) *
                      SmoothStep(std::max(4 * noise, 0.08f), std::max(8 * noise, 0.2f), away);
  const float whole = alpha + (1 - alpha) * other;
  return {whole, std::max(other, SmoothStep(4 * noise, 12 * noise, std::sqrt(length)))};
}

void ByBackground(const Image& frame,
                  const StillBackground& still,
                  const Image& person,
                  const Image& rim,
                  const Radii& r,
                  Image& result) {
  const Image clear = Where(person, [](float a) { return a < kClearMatte; });
  Image sure(frame.width, frame.height, 1);  // as the network and the frame's colours say
  for (size_t i = 0; i < sure.data.size(); ++i)
    sure.data[i] = person.data[i] > kSure && result.data[i] > kSure ? 1.f : 0.f;
  const Behind behind = BehindOf(frame, still, clear, r);
  const Image near = MeanColor(frame, sure, r.window), far = MeanColor(frame, sure, 3 * r.window);
  // Where colours take all around a pixel for the person's, and it is none of the background, a
  // person of several colours must not look like a mixture of one of them and the background.
  Image other(frame.width, frame.height, 1);  // than the background
  for (size_t i = 0; i < rim.data.size(); ++i)
    other.data[i] = SmoothStep(4 * behind.noise.data[i],
                               10 * std::max(behind.noise.data[i], kCodecNoise),
                               Largest(&frame.data[3 * i], &behind.color.data[3 * i]));
  Image inner = other;
  for (size_t i = 0; i < rim.data.size(); ++i) inner.data[i] *= result.data[i];
  inner = BoxMean(inner, 2);
  constexpr float kFew = 0.01f;  // share of the window
  for (size_t i = 0; i < rim.data.size(); ++i) {
    const float* inside = near.data[4 * i + 3] > kFew ? &near.data[4 * i] : &far.data[4 * i];
    if (behind.noise.data[i] < 0 || rim.data[i] == 0 || inside[3] == 0) continue;
    const Difference d =
        Compare(&frame.data[3 * i], inside, &behind.color.data[3 * i], behind.noise.data[i]);
    float weight = behind.trust.data[i] * d.weight * (1 - SmoothStep(0.8f, 0.95f, inner.data[i]));
    // Grey hair may look like dark hair before a light wall, and differs from frame to frame then:
    // what the network takes for the person goes only where the background is seen.
    if (d.alpha < result.data[i] && person.data[i] > 0.5f) weight *= 1 - other.data[i];
    result.data[i] += weight * (d.alpha - result.data[i]);
  }
}

// The extent of what is above 0, with a margin: nothing else is worked on. The first pixel if
// nothing is.
Crop Around(const Image& person, int margin) {
  int left = person.width, top = person.height, right = 0, bottom = 0;  // the last ones excluded
  for (int y = 0; y < person.height; ++y)
    for (int x = 0; x < person.width; ++x)
      if (person.at(x, y, 0) > 0) {
        left = std::min(left, x), right = std::max(right, x + 1);
        top = std::min(top, y), bottom = std::max(bottom, y + 1);
      }
  if (right == 0) return {0, 0, 1, 1};
  left = std::max(left - margin, 0), right = std::min(right + margin, person.width);
  top = std::max(top - margin, 0), bottom = std::min(bottom + margin, person.height);
  return {left, top, right - left, bottom - top};
}

constexpr float kHaze = 0.03f;  // of a codec's noise, in the background's difference
constexpr size_t kMaxBytes = size_t(200) << 20;  // of frames held for the background
constexpr size_t kMaxFrames = 48;

}  // namespace

MatteRefiner::MatteRefiner(const MatteVideo& video) : video_(video) {
  const Image8 first = video.matte(0);
  const size_t room = std::max<size_t>(8, kMaxBytes / (4 * first.pixels()));
  const size_t count = std::min({room, kMaxFrames, size_t(video.frames)});
  std::vector<Image8> frames(count), mattes(count);
  tbb::parallel_for(size_t(0), count, [&](size_t i) {
    const int f = int(i * size_t(video.frames) / count);
    frames[i] = video.image(f);
    mattes[i] = video.matte(f);
  });
  const Radii r(video.network_px);
  things_ = FindStillThings(frames, mattes, r.rim);
  const int near = std::max(1, int(std::lround(video.network_px)));
  tbb::parallel_for(size_t(0), count, [&](size_t i) {  // mattes become what is clear of the person
    const Image person =
        Dilated(Where(ToFloat(mattes[i]), [](float a) { return a > kClearMatte; }), near);
    for (size_t k = 0; k < person.data.size(); ++k)
      mattes[i].data[k] = person.data[k] == 0 || things_.data[k] != 0;
  });
  background_ = FindStillBackground(frames, mattes);
}

Image8 MatteRefiner::Refine(int frame) const {
  const Radii r(video_.network_px);
  const Image image = ToFloat(video_.image(frame));
  Image8 matte = video_.matte(frame);
  TakeOut(things_, image, background_, matte);
  const Image person = PersonOf(matte, video_.face(frame), r.window);
  const Crop crop = Around(person, 3 * r.window);
  const Image part = Cropped(image, crop), raw = Cropped(person, crop), rim = RimOf(raw, r.rim);
  Image result = GuidedRim(part, raw, rim, r);
  const StillBackground behind{Cropped(background_.color, crop), Cropped(background_.noise, crop)};
  ByBackground(part, behind, raw, rim, r, result);
  for (float& alpha : result.data) alpha = (alpha - kHaze) / (1 - 2 * kHaze);  // ToBytes clamps
  const Image8 found = ToBytes(result);
  std::fill(matte.data.begin(), matte.data.end(), uint8_t(0));
  for (int y = 0; y < found.height; ++y)
    std::copy_n(&found.at(0, y, 0), found.width, &matte.at(crop.x, crop.y + y, 0));
  return matte;
}

}  // namespace cosplat

#include "avatar/train/wide_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "avatar/math/one_euro.h"

namespace cosplat {
namespace {

using math::Vec3;

// Over which distance beyond all borders the person fades out, metres for a scale of 1; wide views
// show as much again.
constexpr float kFade = 0.04f;
// The person reaches a border that has so large a share of it.
constexpr float kAtBorder = 0.02f;
// Colours are means over so much of the border to either side, in units of the distance from it.
constexpr float kBlur = 0.7f;
constexpr int kBlurSamples = 8;  // to either side

float Outside(float x, float least, float most) { return std::max({0.0f, least - x, x - most}); }

// [R, G, B, alpha] of the image's pixel that is nearest to a point, and of those beside it along
// the border: means, colours weighted by alpha. [0, 255].
std::array<float, 4> AtBorder(const Image8& image, float x, float y) {
  const float beside = Outside(x, 0, float(image.width)),
              above = Outside(y, 0, float(image.height));
  const float step = kBlur * std::hypot(beside, above) / kBlurSamples;
  const bool along_x = above > beside;
  std::array<float, 4> sum{};
  for (int k = -kBlurSamples; k <= kBlurSamples; ++k) {
    const float at_x = x + (along_x ? step * float(k) : 0),
                at_y = y + (along_x ? 0 : step * float(k));
    const auto within = [](float at, int size) {
      return std::clamp(int(std::floor(at)), 0, size - 1);
    };
    const int column = within(at_x, image.width), row = within(at_y, image.height);
    const float alpha = float(image.at(column, row, 3));
    for (int c = 0; c < 3; ++c) sum[size_t(c)] += alpha * float(image.at(column, row, c));
    sum[3] += alpha;
  }
  for (size_t c = 0; c < 3; ++c) sum[c] /= std::max(sum[3], 1.0f);
  sum[3] /= 2 * kBlurSamples + 1;
  return sum;
}

}  // namespace

float InFrameShare(const Camera& camera, const ImagePoint& at, float scale) {
  if (!(at.depth > 0)) return 0;
  const float beside = Outside(at.x, 0, float(camera.width)) / camera.fx;
  const float above = Outside(at.y, 0, float(camera.height)) / camera.fy;
  return 1 - math::Ease(std::hypot(beside, above) * at.depth / (kFade * scale));
}

FilmedBox FilmedBoxOf(const std::vector<BodyInFrame>& frames) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  FilmedBox box{kFar, -kFar, kFar, -kFar};
  for (const BodyInFrame& seen : frames) {
    const Camera& c = seen.frame->camera;
    const ImagePoint at = Project(c, seen.anchor);
    const float per_px_x = at.depth / c.fx, per_px_y = at.depth / c.fy;
    box.left = std::min(box.left, -at.x * per_px_x);
    box.right = std::max(box.right, (float(c.width) - at.x) * per_px_x);
    box.top = std::min(box.top, -at.y * per_px_y);
    box.bottom = std::max(box.bottom, (float(c.height) - at.y) * per_px_y);
  }
  return box;
}

bool ReachesBorder(const TrainFrame& frame) {
  const Image8& image = frame.target;
  int opaque = 0;
  const auto count = [&](int x, int y) { opaque += image.at(x, y, 3) >= 128; };
  for (int x = 0; x < image.width; ++x) count(x, 0), count(x, image.height - 1);
  for (int y = 0; y < image.height; ++y) count(0, y), count(image.width - 1, y);
  return float(opaque) > kAtBorder * float(2 * (image.width + image.height));
}

TrainFrame ToWideView(const BodyInFrame& source, const FilmedBox& metres, float scale) {
  const Camera& camera = source.frame->camera;
  const Image8& image = source.frame->target;
  const ImagePoint anchor = Project(camera, source.anchor);
  // Lengths from here on are in units of the body's depth.
  const float per_metre = 1 / anchor.depth, fade = kFade * scale * per_metre;
  const FilmedBox box{metres.left * per_metre,
                      metres.right * per_metre,
                      metres.top * per_metre,
                      metres.bottom * per_metre};
  TrainFrame wide;
  wide.camera = camera;
  Camera& c = wide.camera;
  const float width = float(c.width), height = float(c.height);
  const float share = std::min({1.0f,
                                width / (camera.fx * (box.right - box.left + 4 * fade)),
                                height / (camera.fy * (box.bottom - box.top + 4 * fade))});
  c.fx *= share;
  c.fy *= share;
  // The middle of the box is that of the image.
  const float to_anchor_x = (anchor.x - camera.cx) / camera.fx;
  const float to_anchor_y = (anchor.y - camera.cy) / camera.fy;
  c.cx = 0.5f * width - c.fx * (to_anchor_x + 0.5f * (box.left + box.right));
  c.cy = 0.5f * height - c.fy * (to_anchor_y + 0.5f * (box.top + box.bottom));
  wide.target = Image8(c.width, c.height, 4);
  wide.ignored = Image8(c.width, c.height, 1);
  for (int row = 0; row < c.height; ++row)
    for (int column = 0; column < c.width; ++column) {
      const float x = (float(column) + 0.5f - c.cx) / c.fx, y = (float(row) + 0.5f - c.cy) / c.fy;
      const float beyond = std::hypot(Outside(x - to_anchor_x, box.left, box.right),
                                      Outside(y - to_anchor_y, box.top, box.bottom));
      const size_t pixel = size_t(row) * size_t(c.width) + size_t(column);
      wide.ignored.data[pixel] = beyond == 0 ? 255 : 0;
      if (beyond == 0 || beyond >= fade) continue;
      const std::array<float, 4> border =
          AtBorder(image, camera.cx + camera.fx * x, camera.cy + camera.fy * y);
      for (size_t k = 0; k < 3; ++k) wide.target.data[4 * pixel + k] = uint8_t(border[k] + 0.5f);
      wide.target.data[4 * pixel + 3] = uint8_t(border[3] * (1 - math::Ease(beyond / fade)) + 0.5f);
    }
  return wide;
}

}  // namespace cosplat

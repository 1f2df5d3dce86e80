#include "apps/study/mattes/made_video.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "assets/head/motion.h"
#include "assets/head/noise.h"
#include "assets/head/procedural_head.h"
#include "flame/pose.h"
#include "splat/base/rng.h"
#include "splat/media/image_filters.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

using procedural::HashUnit;
using procedural::Noise2;
using Color = std::array<float, 3>;

constexpr int kNetwork = 256;

// Colours of a wall's cells and what hangs on them. x, y in widths of the image.
Color Room(float x, float y, int seed) {
  constexpr float kCells = 5;
  const float u = kCells * x, v = kCells * y;
  const int column = procedural::FloorOf(u), row = procedural::FloorOf(v);
  const float wall = 0.55f + 0.25f * Noise2(2 * x, 2 * y, 0, seed);
  const float a = u - float(column), b = v - float(row);
  const float margin = 0.1f + 0.25f * HashUnit(column, row, seed + 1);
  const bool framed = a > margin && a < 1 - margin && b > margin && b < 1 - margin;
  Color color{wall, 0.97f * wall, 0.9f * wall};
  for (size_t c = 0; c < 3; ++c)
    if (framed)
      color[c] = 0.8f * HashUnit(column, row, seed + 2 + int(c)) +
                 0.2f * Noise2(12 * u, 12 * v, 0, seed + 5);
  return color;
}

// Fine patterns between the colours of skin, hair and paper.
Color Busy(float x, float y, int seed) {
  static constexpr Color kColors[] = {
      {0.80f, 0.60f, 0.50f}, {0.20f, 0.13f, 0.10f}, {0.9f, 0.9f, 0.85f}, {0.3f, 0.4f, 0.5f}};
  const float kind =
      3 * Noise2(14 * x, 14 * y, 0, seed) + 0.6f * Noise2(60 * x, 60 * y, 0, seed + 1);
  const size_t k = std::min(size_t(kind), size_t(2));
  const float t = std::clamp(4 * (kind - float(k) - 0.4f), 0.f, 1.f);
  Color color{};
  for (size_t c = 0; c < 3; ++c)
    color[c] = (1 - t) * kColors[k][c] + t * kColors[k + 1][c] +
               0.1f * (Noise2(110 * x, 110 * y, 0, seed + 2) - 0.5f);
  return color;
}

Color Behind(MadeBackground background, float x, float y, int frame, int seed) {
  if (background == MadeBackground::kStill) return Room(x, y, seed);
  const float t = 0.11f * float(frame);
  if (background == MadeBackground::kMoving)
    return Room(x + 0.06f * std::sin(t) + 0.01f * std::sin(5 * t),
                y + 0.03f * std::sin(1.7f * t) + 0.01f * std::cos(4 * t),
                seed);
  // Somebody walks through it.
  const float walker = 0.5f + 0.7f * std::sin(0.7f * t);
  if (std::abs(x - walker) < 0.09f && y > 0.3f) return Busy(x - walker, y, seed + 9);
  return Busy(x, y, seed);
}

float Bilinear(const Image& image, float x, float y) {
  x = std::clamp(x - 0.5f, 0.f, float(image.width - 1));
  y = std::clamp(y - 0.5f, 0.f, float(image.height - 1));
  const int x0 = int(x), y0 = int(y);
  const int x1 = std::min(x0 + 1, image.width - 1), y1 = std::min(y0 + 1, image.height - 1);
  const float u = x - float(x0), v = y - float(y0);
  return (1 - v) * ((1 - u) * image.at(x0, y0, 0) + u * image.at(x1, y0, 0)) +
         v * ((1 - u) * image.at(x0, y1, 0) + u * image.at(x1, y1, 0));
}

// How far the made network's rim is off, its pixels.
constexpr float kWander = 1.9f;

Image8 NetworkMatte(const Image8& truth, int frame, int seed) {
  const Image small = ToFloat(ResizeByArea(truth, kNetwork, kNetwork));
  Image matte(kNetwork, kNetwork, 1);
  const int slow = seed + 100 + frame / 4, fast = seed + 1000 + frame;
  const float island_x = 256 * HashUnit(slow, 1, seed), island_y = 200 * HashUnit(slow, 2, seed);
  for (int y = 0; y < kNetwork; ++y)
    for (int x = 0; x < kNetwork; ++x) {
      const auto wander = [&](int axis) {
        const float u = float(x) / 14, v = float(y) / 14;
        return 2 * kWander *
               (0.7f * Noise2(u, v, 0, slow + 7 * axis) + 0.3f * Noise2(u, v, 0, fast + axis) -
                0.5f);
      };
      const float px = float(x) + 0.5f, py = float(y) + 0.5f;
      const float island = std::hypot(px - island_x, py - island_y);
      matte.at(x, y, 0) = std::max(Bilinear(small, px + 2 * wander(0), py + 2 * wander(1)),
                                   island < 5 ? 0.8f : 0.f);
      if (frame % 5 == 0 && std::hypot(px - 128, py - 90) < 4) matte.at(x, y, 0) = 0.2f;
    }
  matte = BoxMean(BoxMean(matte, 1), 1);
  Image large(truth.width, truth.height, 1);
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x)
      large.at(x, y, 0) = Bilinear(matte,
                                   (float(x) + 0.5f) * kNetwork / float(truth.width),
                                   (float(y) + 0.5f) * kNetwork / float(truth.height));
  return ToBytes(large);
}

// The middle of the head: the matte's upper part.
FaceBox FaceOf(const Image8& truth) {
  int left = truth.width, right = 0, top = truth.height;
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x)
      if (truth.at(x, y, 0) > 127) {
        left = std::min(left, x), right = std::max(right, x);
        top = std::min(top, y);
      }
  const double width = double(right - left), middle = 0.5 * (left + right);
  return {middle - width / 4, top + width / 3, middle + width / 4, top + width};
}

}  // namespace

const char* NameOf(MadeBackground background) {
  static constexpr const char* kNames[] = {"still", "moving", "busy"};
  return kNames[int(background)];
}

double MadeNetworkPx(int size) { return double(size) / kNetwork; }

std::vector<Image8> DrawHeads(int frames, int size, unsigned seed) {
  const ProceduralHead head = MakeProceduralHeadParts();
  const FlamePoser<float> poser(head.model, {});
  const auto script = procedural::MakeScript({frames, 0, size, seed});
  std::vector<Image8> heads(script.size());
  tbb::parallel_for(size_t(0), script.size(), [&](size_t f) {
    std::vector<float> vertices;
    poser.Forward(FlamePoser<float>::ParametersOf(script[f].params), vertices);
    heads[f] = RenderProceduralHead(head, vertices, script[f].params, script[f].camera);
  });
  return heads;
}

std::vector<MatteFrame> Compose(const std::vector<Image8>& heads,
                                MadeBackground background,
                                unsigned seed) {
  constexpr float kCameraNoise = 1.5f / 255;
  std::vector<MatteFrame> frames(heads.size());
  tbb::parallel_for(size_t(0), heads.size(), [&](size_t f) {
    const Image8& head = heads[f];
    const int frame = int(f);
    MatteFrame& made = frames[f];
    made.truth = Image8(head.width, head.height, 1);
    Image image(head.width, head.height, 3);
    Rng rng{seed * 1000003ull + f};
    for (int y = 0; y < head.height; ++y)
      for (int x = 0; x < head.width; ++x) {
        made.truth.at(x, y, 0) = head.at(x, y, 3);
        const float alpha = float(head.at(x, y, 3)) / 255;
        const Color behind = Behind(background,
                                    float(x) / float(head.width),
                                    float(y) / float(head.width),
                                    frame,
                                    int(seed));
        for (int c = 0; c < 3; ++c)
          image.at(x, y, c) = alpha * float(head.at(x, y, c)) / 255 +
                              (1 - alpha) * behind[size_t(c)] + kCameraNoise * rng.Normal();
      }
    made.image = ToBytes(image);
    made.matte = NetworkMatte(made.truth, frame, int(seed));
    made.face = FaceOf(made.truth);
  });
  return frames;
}

}  // namespace cosplat

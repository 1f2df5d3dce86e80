#include "flame/io/track_fit.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "splat/base/text.h"

namespace cosplat {
namespace {

// Real heads have 15.9 and 20.9 of 255 as they are, 17.4 to 23.6 (8 % more or above) with images of
// the next or last frame, and 21.9 and more (38 %) with mirrored ones.
constexpr double kShiftGain = 0.05, kFlipGain = 0.15;
constexpr double kNoise = 1;  // of 255; what a still head's colours change by is its codec's
// Overlap of the head's upper part with the masks (OverlapOf): 0.95 and 0.84 of real heads. Those
// that are seen 0.7 or 1.5 times as large, or an eighth of the image aside, gain 0.18 to 0.43 where
// they belong.
constexpr double kOverlapGain = 0.1;

// How the head could lie instead: larger about the principal point, and aside by a share of the
// image's size.
struct Misfit {
  float scale = 1, right = 0, down = 0;
  const char* what = "";

  std::array<float, 2> Of(const Sighting& point, const Camera& c) const {
    return {c.cx + scale * (point.x - c.cx) + right * float(c.width),
            c.cy + scale * (point.y - c.cy) + down * float(c.height)};
  }
};
constexpr Misfit kPlaces[] = {{0.5f, 0, 0, "half as large"},
                              {0.7f, 0, 0, "0.7 times as large"},
                              {1.4f, 0, 0, "1.4 times as large"},
                              {2, 0, 0, "twice as large"},
                              {1, -0.25f, 0, "a quarter of the image to the left"},
                              {1, -0.12f, 0, "an eighth of the image to the left"},
                              {1, 0.12f, 0, "an eighth of the image to the right"},
                              {1, 0.25f, 0, "a quarter of the image to the right"},
                              {1, 0, -0.25f, "a quarter of the image higher"},
                              {1, 0, -0.12f, "an eighth of the image higher"},
                              {1, 0, 0.12f, "an eighth of the image lower"},
                              {1, 0, 0.25f, "a quarter of the image lower"}};

// Which image a frame is compared with, and where the head is in it.
struct Reading {
  int shift = 0;  // frames later
  bool mirror_x = false, mirror_y = false;
  Misfit place;
};

// Of the visible points' colours, means, of 255.
struct ColorSpread {
  double change = HUGE_VAL;  // of a point, from frame to frame: its deviation; if enough are seen
  double contrast = 0;       // of its mean colour to those beside it
  // What images that are mirrored are judged by: the wall, or the empty mask, beside a head that is
  // not in the middle does not change either, but has no contrast.
  double blur() const { return contrast > 0 ? (change + kNoise) / contrast : HUGE_VAL; }
};

ColorSpread SpreadOf(const FlameModel& flame,
                     const std::vector<SeenFrame>& all,
                     const Reading& reading) {
  const size_t vertices = all[0].points.size();
  std::vector<std::array<double, 3>> sum(vertices), squares(vertices), mean(vertices);
  std::vector<size_t> count(vertices);
  for (const SeenFrame& seen : all) {
    const Image8& image = seen.images[size_t(kShifts + reading.shift)];
    if (image.empty()) return {};
    for (size_t v = 0; v < vertices; ++v) {
      if (!seen.visible[v]) continue;
      const auto [px, py] = reading.place.Of(seen.points[v], seen.camera);
      if (!(px >= 0 && py >= 0 && px < float(seen.camera.width) && py < float(seen.camera.height)))
        continue;
      int x = std::min(int(px), image.width - 1), y = std::min(int(py), image.height - 1);
      if (reading.mirror_x) x = image.width - 1 - x;
      if (reading.mirror_y) y = image.height - 1 - y;
      const double alpha = image.channels == 4 ? image.at(x, y, 3) / 255.0 : 1;
      for (int c = 0; c < 3; ++c) {
        const double value = alpha * image.at(x, y, c);
        sum[v][size_t(c)] += value, squares[v][size_t(c)] += value * value;
      }
      ++count[v];
    }
  }
  const auto is_used = [&](size_t v) { return v < vertices && 2 * count[v] >= all.size(); };
  double change = 0, contrast = 0;
  size_t used = 0, beside = 0;
  for (size_t v = 0; v < vertices; ++v) {
    if (!is_used(v)) continue;
    for (size_t c = 0; c < 3; ++c) {
      const double m = mean[v][c] = sum[v][c] / double(count[v]);
      change += std::sqrt(std::max(0.0, squares[v][c] / double(count[v]) - m * m));
    }
    used += 3;
  }
  if (used < 300) return {};
  for (const auto& face : flame.faces)
    for (size_t k = 0; k < 3; ++k) {
      const size_t a = size_t(face[k]), b = size_t(face[(k + 1) % 3]);
      if (!is_used(a) || !is_used(b)) continue;
      for (size_t c = 0; c < 3; ++c) contrast += std::abs(mean[a][c] - mean[b][c]);
      beside += 3;
    }
  return {change / double(used), beside > 0 ? contrast / double(beside) : 0};
}

// The head's silhouette, of the model's own triangles, which are small: a few points of each.
Image8 SilhouetteOf(const FlameModel& flame, const SeenFrame& seen, const Misfit& place) {
  constexpr int kSteps = 4;
  Image8 shape(seen.image().width, seen.image().height, 1);
  const Camera& c = seen.camera;
  for (const auto& face : flame.faces) {
    if (size_t(std::max({face[0], face[1], face[2]})) >= seen.points.size()) continue;
    float x[3], y[3];
    for (size_t k = 0; k < 3; ++k) {
      const Sighting& p = seen.points[size_t(face[k])];
      const auto [u, v] = place.Of(p, c);
      x[k] = u, y[k] = v;
    }
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const float a = float(i) / kSteps, b = float(j) / kSteps, d = 1 - a - b;
        const float u = a * x[0] + b * x[1] + d * x[2], v = a * y[0] + b * y[1] + d * y[2];
        if (u >= 0 && v >= 0 && u < float(shape.width) && v < float(shape.height))
          shape.at(int(u), int(v), 0) = 255;
      }
  }
  return shape;
}

// Intersection over union of the silhouette's upper 70 %, where shoulders are not. Hair is left
// out: what the mask has beside and above the skull, its upper half, within a fifth of the head's
// height.
double OverlapOf(const Image8& shape, const Image8& image) {
  int top = shape.height, lowest = 0;
  for (int y = 0; y < shape.height; ++y)
    for (int x = 0; x < shape.width; ++x)
      if (shape.at(x, y, 0)) top = std::min(top, y), lowest = y;
  const int height = lowest - top, reach = height / 5, skull = top + height / 3;
  // Columns of the skull, as far as hair reaches.
  int left = shape.width, right = 0;
  for (int y = top; y <= std::min(skull, shape.height - 1); ++y)
    for (int x = 0; x < shape.width; ++x)
      if (shape.at(x, y, 0)) left = std::min(left, x - reach), right = std::max(right, x + reach);
  size_t both = 0, any = 0;
  for (int y = 0; y <= top + 7 * height / 10 && y < shape.height; ++y)
    for (int x = 0; x < shape.width; ++x) {
      const bool head = shape.at(x, y, 0) != 0, mask = image.at(x, y, 3) > 127;
      const bool hair = y >= top - reach && y <= skull && x >= left && x <= right;
      both += head && mask, any += head || (mask && !hair);
    }
  return any == 0 ? 0 : double(both) / double(any);
}

}  // namespace

void CheckPlace(const FlameModel& flame,
                const std::vector<SeenFrame>& all,
                std::vector<Finding>& findings) {
  const auto overlap = [&](const Misfit& place) {
    double sum = 0;
    size_t count = 0;
    for (const SeenFrame& seen : all) {
      if (seen.image().channels != 4) continue;
      sum += OverlapOf(SilhouetteOf(flame, seen, place), seen.image());
      ++count;
    }
    return count == 0 ? 0 : sum / double(count);
  };
  const double given = overlap({});
  double max = given + kOverlapGain;
  const Misfit* better = nullptr;
  for (const Misfit& place : kPlaces)
    if (const double there = overlap(place); there > max) max = there, better = &place;
  if (better == nullptr) return;
  // Hair all around, a hat or a chair may be in the masks: of a head that moves, its colours tell.
  const ColorSpread here = SpreadOf(flame, all, {}),
                    there = SpreadOf(flame, all, {0, false, false, *better});
  const bool colors_tell = here.change >= kNoise && here.change < HUGE_VAL;
  if (colors_tell && there.blur() >= here.blur()) return;
  findings.push_back({true,
                      "the masks overlap the head by " + Format("{:.0f}", 100 * given) +
                          " %, and by " + Format("{:.0f}", 100 * max) + " % if it were seen " +
                          better->what + ": look at focal length, principal point and units"});
}

// Points of a head look alike from frame to frame, if images and track belong together.
void CheckHeadColors(const FlameModel& flame,
                     const std::vector<SeenFrame>& all,
                     std::vector<Finding>& findings) {
  const ColorSpread as_given = SpreadOf(flame, all, {});
  const double given = as_given.change;
  if (given < kNoise || given == HUGE_VAL || all.size() < 4) return;
  const auto say = [&](double min, const std::string& with, const char* advice) {
    findings.push_back({true,
                        "the head's points change colour by " + Format("{:.1f}", given) +
                            " of 255 from frame to frame, and by " + Format("{:.1f}", min) +
                            " with " + with + ": " + advice});
  };
  const char* what[4] = {"", "mirrored left to right", "mirrored top to bottom", "upside down"};
  int best = 0;
  double blur = (1 - kFlipGain) * as_given.blur(), min = given;
  for (int flip = 1; flip < 4; ++flip) {
    const ColorSpread seen = SpreadOf(flame, all, {0, (flip & 1) != 0, (flip & 2) != 0, {}});
    if (seen.blur() < blur && seen.change < (1 - kFlipGain) * given)
      blur = seen.blur(), min = seen.change, best = flip;
  }
  if (best != 0)
    return say(min, std::string("the images ") + what[best], "turn the images, or the track");
  min = (1 - kShiftGain) * given;
  for (int shift = -kShifts; shift <= kShifts; ++shift) {
    const double change = SpreadOf(flame, all, {shift, false, false, {}}).change;
    if (change < min) min = change, best = shift;
  }
  if (best != 0)
    say(min,
        Format("images {}{}", std::abs(best), best > 0 ? " frames later" : " frames earlier"),
        "track and images do not agree in time; look for dropped or renumbered frames");
}

}  // namespace cosplat

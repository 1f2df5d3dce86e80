#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "flame/pose.h"
#include "flame/track.h"
#include "splat/base/text.h"
#include "splat/media/image_glance.h"

namespace cosplat {
namespace {

constexpr size_t kLookedAt = 24;       // frames, one of each part of the video
constexpr size_t kCandidates = 12;     // of a part: the one whose head moves most is looked at
constexpr int kSide = 256;             // px
constexpr double kFlat = 1.5;          // contrast, of 255
constexpr double kInside = 0.5;        // share of the head
constexpr float kGreatExpression = 6;  // standard deviations

// Real heads have 15.9 and 20.9 of 255 as they are, 17.4 to 23.6 (8 % more or above) with images of
// the next or last frame, and 21.9 and more (38 %) with mirrored ones.
constexpr int kShifts = 2;
constexpr double kShiftGain = 0.05, kFlipGain = 0.15;
constexpr double kNoise = 1;  // of 255; what a still head's colours change by is its codec's
// Overlap of the head's upper part with the masks (OverlapOf): 0.95 and 0.84 of real heads. Those
// that are seen 0.7 or 1.5 times as large, or an eighth of the image aside, gain 0.18 to 0.43 where
// they belong.
constexpr double kOverlapGain = 0.1;

struct SeenFrame {
  const TrackedFrame* frame = nullptr;
  Camera camera;                 // at the reduced size
  std::vector<Sighting> points;  // of the model's own vertices
  std::vector<uint8_t> visible;  // whether they face the camera
  double share_inside = 0;
  std::array<Image8, 2 * kShifts + 1> images;  // of the frames before, its own, those after

  const Image8& image() const { return images[kShifts]; }
};

std::string Of(size_t count, size_t all) {
  return std::to_string(count) + " of " + std::to_string(all) + " frames looked at";
}

void Project(const FlameModel& flame, const std::vector<float>& vertices, SeenFrame& seen) {
  const size_t count = size_t(flame.own_vertex_count());
  std::vector<Sighting> points(size_t(flame.vertex_count));
  std::vector<std::array<float, 3>> normals(points.size());
  for (size_t i = 0; i < points.size(); ++i) points[i] = Sight(seen.camera, &vertices[3 * i]);
  for (const auto& face : flame.faces) {
    const auto& a = points[size_t(face[0])].in_camera;
    const auto &b = points[size_t(face[1])].in_camera, &d = points[size_t(face[2])].in_camera;
    float u[3], v[3];
    for (size_t k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = d[k] - a[k];
    for (size_t k = 0; k < 3; ++k) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      for (const int corner : face) normals[size_t(corner)][k] += u[i] * v[j] - u[j] * v[i];
    }
  }
  seen.visible.resize(count);
  size_t inside = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto &p = points[i].in_camera, &n = normals[i];
    inside += points[i].inside;
    const float towards = -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2]);
    seen.visible[i] = points[i].inside &&
                      towards > 0.5f * std::hypot(n[0], n[1], n[2]) * std::hypot(p[0], p[1], p[2]);
  }
  seen.share_inside = count == 0 ? 1 : double(inside) / double(count);
  points.resize(count);
  seen.points = std::move(points);
}

// Sum of the distances in px, of every eighth vertex.
double Motion(const SeenFrame& a, const SeenFrame& b) {
  double sum = 0;
  for (size_t i = 0; i < a.points.size(); i += 8)
    sum += std::hypot(a.points[i].x - b.points[i].x, a.points[i].y - b.points[i].y);
  return sum;
}

// VHAP's offsets have rows for teeth that a model may lack.
FlamePoser<float> PoserOf(const FlameModel& flame, const TrackedVideo& video) {
  std::vector<float> offset = video.static_offset;
  if (!offset.empty()) offset.resize(3 * size_t(flame.vertex_count));
  return FlamePoser<float>(flame, video.shape, offset);
}

std::vector<float> Posed(const FlamePoser<float>& poser,
                         const FlameModel& flame,
                         const TrackedFrame& frame) {
  FlameParams params = frame.params;
  params.expression.resize(std::min(params.expression.size(), size_t(flame.expression_count)));
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(params), vertices);
  return vertices;
}

// From each part of the video the frame whose head has moved most since the frame before, since
// motion shows what does not agree.
std::vector<SeenFrame> LookAt(const FlameModel& flame, const TrackedVideo& video) {
  std::vector<const TrackedFrame*> frames = InstantsOf(video);
  std::erase_if(frames, [](const TrackedFrame* frame) { return !frame->has_image; });
  const FlamePoser<float> poser = PoserOf(flame, video);
  const auto seen_at = [&](size_t i) {
    SeenFrame seen;
    seen.frame = frames[i];
    const Camera& camera = frames[i]->camera;
    const double scale = std::min(1.0, double(kSide) / std::max(camera.width, camera.height));
    seen.camera = camera.Resized(std::max(1, int(scale * camera.width)),
                                 std::max(1, int(scale * camera.height)));
    Project(flame, Posed(poser, flame, *frames[i]), seen);
    return seen;
  };
  std::vector<SeenFrame> all;
  std::vector<size_t> at;
  const size_t n = frames.size(), ends = n > 2 * kShifts ? kShifts : 0, middle = n - 2 * ends,
               parts = std::min(kLookedAt, middle);
  for (size_t part = 0; part < parts; ++part) {
    const size_t first = ends + part * middle / parts, last = ends + (part + 1) * middle / parts;
    SeenFrame before = seen_at(first > 0 ? first - 1 : 0), best;
    double max = -1;
    at.push_back(first);
    for (size_t i = first; i < std::min(last, first + kCandidates); ++i) {
      SeenFrame seen = seen_at(i);
      const double motion = Motion(before, seen);
      before = seen;
      if (motion <= max) continue;
      max = motion, best = std::move(seen), at.back() = i;
    }
    all.push_back(std::move(best));
  }
  const auto load = [&](size_t k) {
    for (int shift = -kShifts; shift <= kShifts; ++shift) {
      const ptrdiff_t i = ptrdiff_t(at[k]) + shift;
      if (i < 0 || i >= ptrdiff_t(n)) continue;
      all[k].images[size_t(kShifts + shift)] =
          ReducedTo(LoadTrackedImage(video, *frames[size_t(i)]), kSide);
    }
  };
  if (video.video)  // in order: it is decoded from its beginning
    for (size_t k = 0; k < all.size(); ++k) load(k);
  else
    tbb::parallel_for(size_t(0), all.size(), load);
  return all;
}

// How many frames a condition holds for, and the first of them.
struct Count {
  size_t frames = 0;
  std::string first;
  void Add(const SeenFrame& seen) {
    if (frames++ == 0) first = seen.frame->name;
  }
};

void CheckImages(const std::vector<SeenFrame>& all, std::vector<Finding>& findings) {
  Count outside, flat, empty, repeated;
  for (const SeenFrame& seen : all) {
    if (seen.share_inside < kInside) outside.Add(seen);
    if (GreatestAlpha(seen.image()) == 0)
      empty.Add(seen);
    else if (ContrastOf(seen.image()) < kFlat)
      flat.Add(seen);
    else if (seen.images[kShifts - 1].data == seen.image().data)
      repeated.Add(seen);
  }
  const auto say = [&](const Count& count, const std::string& what) {
    if (count.frames > 0)
      findings.push_back(
          {2 * count.frames >= all.size(),
           "in " + Of(count.frames, all.size()) + " " + what + " (first: " + count.first + ")"});
  };
  say(outside, "less than half of the head is inside the image: look at camera and focal length");
  say(empty, "the mask shows nothing: look at the masks");
  say(flat, "the image is nearly of one colour: there is nothing to learn from it");
  say(repeated, "the image is that of the frame before: look at the image files");
}

// Share of the head's points that masks hold.
void CheckMasks(const std::vector<SeenFrame>& all, std::vector<Finding>& findings) {
  double held = 0, points = 0;
  for (const SeenFrame& seen : all) {
    if (seen.image().channels != 4) continue;
    for (const Sighting& point : seen.points)
      if (point.inside) {
        held += seen.image().at(int(point.x), int(point.y), 3) / 255.0;
        ++points;
      }
  }
  if (points > 0 && held < kInside * points)
    findings.push_back({true,
                        "the masks hold only " + Format("{:.0f}", 100 * held / points) +
                            " % of the head where the track says it is: look at masks, images and "
                            "cameras"});
}

// How the head could lie instead: larger about the principal point, and aside by a share of the
// image's size.
struct Misfit {
  float scale = 1, right = 0, down = 0;
  const char* what = "";
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
      x[k] = c.cx + place.scale * (p.x - c.cx) + place.right * float(c.width);
      y[k] = c.cy + place.scale * (p.y - c.cy) + place.down * float(c.height);
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
  findings.push_back({true,
                      "the masks overlap the head by " + Format("{:.0f}", 100 * given) +
                          " %, and by " + Format("{:.0f}", 100 * max) + " % if it were seen " +
                          better->what + ": look at focal length, principal point and units"});
}

// Which image a frame is compared with.
struct Reading {
  int shift = 0;  // frames later
  bool mirror_x = false, mirror_y = false;
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
      int x = std::min(int(seen.points[v].x), image.width - 1),
          y = std::min(int(seen.points[v].y), image.height - 1);
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

// Points of a head look alike from frame to frame, if images and track belong together.
void CheckColors(const FlameModel& flame,
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
    const ColorSpread seen = SpreadOf(flame, all, {0, (flip & 1) != 0, (flip & 2) != 0});
    if (seen.blur() < blur && seen.change < (1 - kFlipGain) * given)
      blur = seen.blur(), min = seen.change, best = flip;
  }
  if (best != 0)
    return say(min, std::string("the images ") + what[best], "turn the images, or the track");
  min = (1 - kShiftGain) * given;
  for (int shift = -kShifts; shift <= kShifts; ++shift) {
    const double change = SpreadOf(flame, all, {shift}).change;
    if (change < min) min = change, best = shift;
  }
  if (best != 0)
    say(min,
        Format("images {}{}", std::abs(best), best > 0 ? " frames later" : " frames earlier"),
        "track and images do not agree in time; look for dropped or renumbered frames");
}

void CheckExpressions(const FlameModel& flame,
                      const std::vector<SeenFrame>& all,
                      std::vector<Finding>& findings) {
  Count great, more;
  float greatest = 0;
  size_t max = 0;
  for (const SeenFrame& seen : all) {
    const std::vector<float>& e = seen.frame->params.expression;
    float frame_greatest = 0;
    for (const float value : e) frame_greatest = std::max(frame_greatest, std::abs(value));
    if (frame_greatest > kGreatExpression) great.Add(seen);
    greatest = std::max(greatest, frame_greatest);
    size_t used = e.size();
    while (used > 0 && e[used - 1] == 0) --used;
    if (used > size_t(flame.expression_count)) more.Add(seen);
    max = std::max(max, used);
  }
  if (8 * great.frames > all.size())
    findings.push_back({2 * great.frames >= all.size(),
                        "in " + Of(great.frames, all.size()) +
                            " expressions go beyond 6 standard deviations (to " +
                            Format("{:.1f}", greatest) + ", first: " + great.first +
                            "): is it the tracker's model?"});
  if (more.frames > 0)
    findings.push_back({false,
                        "the track has " + std::to_string(max) +
                            " expression coefficients, and the model " +
                            std::to_string(flame.expression_count) +
                            ": the rest is not used; pass the tracker's model"});
}

}  // namespace

std::vector<float> TrackedVertices(const FlameModel& flame,
                                   const TrackedVideo& video,
                                   const TrackedFrame& frame) {
  return Posed(PoserOf(flame, video), flame, frame);
}

std::vector<Finding> CheckTrack(const FlameModel& flame, const TrackedVideo& video) {
  std::vector<Finding> findings;
  const std::vector<SeenFrame> all = LookAt(flame, video);
  if (all.empty()) return findings;
  CheckImages(all, findings);
  CheckMasks(all, findings);
  CheckPlace(flame, all, findings);
  CheckColors(flame, all, findings);
  CheckExpressions(flame, all, findings);
  return findings;
}

}  // namespace cosplat

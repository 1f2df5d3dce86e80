#include "splat/io/scene_fit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr size_t kGroups = 8, kNeighbours = 3;
constexpr int kSide = 320;  // px
constexpr size_t kPoints = 3000;
constexpr size_t kFewPoints = 20;  // fewer say nothing of a view
constexpr double kMinGrey = 3;     // differences below are those of noise

// Mean difference of points' colours from `image` as the camera of `one` sees them; `seen` points.
double ColorDifference(const SceneData& scene,
                       const LookedAt& one,
                       const Image8& image,
                       const Reading& how,
                       size_t& seen) {
  const size_t count = scene.points.size() / 3, step = std::max<size_t>(1, count / kPoints);
  const Camera camera = ReadAs(one.camera, how);
  double sum = 0;
  seen = 0;
  for (size_t i = 0; i < count; i += step) {
    const auto place = PlaceOf(camera, &scene.points[3 * i]);
    if (!place) continue;
    // Images of other views may be of another size.
    const int u = CellOf((*place)[0], image.width), v = CellOf((*place)[1], image.height);
    for (int k = 0; k < 3; ++k)
      sum += std::abs(image.at(u, v, image.channels < 3 ? 0 : k) -
                      scene.point_colors[3 * i + size_t(k)]);
    ++seen;
  }
  return seen == 0 ? 0 : sum / double(3 * seen);
}

// Means over pairs of a view and an image that see enough points.
struct Fit {
  double sum = 0;
  size_t pairs = 0;
  double mean() const { return pairs == 0 ? 0 : sum / double(pairs); }
  void Add(double difference, size_t seen) {
    if (seen < kFewPoints) return;
    sum += difference, ++pairs;
  }
};

std::string Grey(double value) { return Format("{:.1f}", value); }

// The points' difference from their views' images, as a share of that from other views': 0.59 and
// 0.72 of real scenes, 0.9 and more where cameras or images are wrong.
constexpr double kFitsNot = 0.85;
// As a share of the given reading's: other readings of real scenes have 1.23 and more; the right
// one of a scene that is read wrongly 0.86 and less.
constexpr double kFitsBetter = 0.9;
// Between a point and its nearest neighbour, as a share of that between any two: points that a
// program strewed, as 3DGS does for renderings, have 1.
constexpr double kStrewn = 0.85;

// Whether the points' colours are those of a scene: neither all alike nor made up.
bool HaveColors(const SceneData& scene) {
  const size_t count = scene.points.size() / 3, step = std::max<size_t>(1, count / kPoints);
  std::vector<size_t> sample;
  for (size_t i = 0; i < count; i += step) sample.push_back(i);
  if (sample.size() < kFewPoints) return false;
  const auto difference = [&](size_t i, size_t j) {
    int sum = 0;
    for (size_t k = 0; k < 3; ++k)
      sum += std::abs(scene.point_colors[3 * i + k] - scene.point_colors[3 * j + k]);
    return double(sum) / 3;
  };
  double near = 0, any = 0;
  for (size_t a = 0; a < sample.size(); ++a) {
    const float* p = &scene.points[3 * sample[a]];
    size_t nearest = a;
    float min = INFINITY;
    for (size_t b = 0; b < sample.size(); ++b) {
      const float* q = &scene.points[3 * sample[b]];
      const float d = (p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) +
                      (p[2] - q[2]) * (p[2] - q[2]);
      if (b != a && d < min) min = d, nearest = b;
    }
    near += difference(sample[a], sample[nearest]);
    any += difference(sample[a], sample[(a + sample.size() / 2) % sample.size()]);
  }
  return any > kMinGrey * double(sample.size()) && near < kStrewn * any;
}

// Whether the points' colours fit their places better than those beside, by a twentieth of the
// image. They do in images of leaves or grass, too, which other views' images fit nearly as well.
bool FitsItsPlace(const SceneData& scene, const LookedAt& one, double own) {
  double beside = 0;
  for (const auto& [dx, dy] : {std::pair(0.05f, 0.f), {-0.05f, 0.f}, {0.f, 0.05f}, {0.f, -0.05f}}) {
    Reading there;
    there.dx = dx, there.dy = dy;
    size_t seen = 0;
    beside += ColorDifference(scene, one, one.image, there, seen) / 4;
  }
  return own < beside;
}

}  // namespace

Camera ReadAs(Camera camera, const Reading& how) {
  if (how.inverted) {
    const Camera given = camera;
    camera.translation = given.Center();
    for (size_t r = 0; r < 3; ++r)
      for (size_t k = 0; k < 3; ++k) camera.rotation[3 * r + k] = given.rotation[3 * k + r];
  }
  if (how.other_axes) {
    for (size_t k = 3; k < 9; ++k) camera.rotation[k] *= -1;
    for (size_t k = 1; k < 3; ++k) camera.translation[k] *= -1;
  }
  camera.fx *= how.mirror_x ? -how.focal : how.focal;
  camera.fy *= how.mirror_y ? -how.focal : how.focal;
  const auto width = float(camera.width), height = float(camera.height);
  if (how.mirror_x) camera.cx = width - camera.cx;
  if (how.mirror_y) camera.cy = height - camera.cy;
  camera.cx += how.dx * width;
  camera.cy += how.dy * height;
  return camera;
}

std::optional<std::array<float, 2>> PlaceOf(const Camera& c, const float* point) {
  float p[3];
  for (size_t r = 0; r < 3; ++r) {
    p[r] = c.translation[r];
    for (size_t k = 0; k < 3; ++k) p[r] += c.rotation[3 * r + k] * point[k];
  }
  if (!(p[2] > 0)) return {};
  const std::array<float, 2> place{(c.fx * p[0] / p[2] + c.cx) / float(c.width),
                                   (c.fy * p[1] / p[2] + c.cy) / float(c.height)};
  if (!(place[0] >= 0 && place[1] >= 0 && place[0] < 1 && place[1] < 1)) return {};
  return place;
}

void CheckColors(const SceneData& scene,
                 const std::vector<LookedAt>& looked,
                 std::vector<Finding>& findings) {
  Fit given, exchanged, shifted[2];
  size_t blind = 0, in_place = 0;
  std::string blind_name;
  for (size_t i = 0; i < looked.size(); ++i) {
    size_t seen = 0;
    const double own = ColorDifference(scene, looked[i], looked[i].image, {}, seen);
    given.Add(own, seen);
    in_place += seen >= kFewPoints && FitsItsPlace(scene, looked[i], own);
    if (seen == 0 && blind++ == 0) blind_name = looked[i].view->name;
    const size_t other = (i + kNeighbours) % looked.size();
    if (looked[other].group != looked[i].group) {
      const double difference = ColorDifference(scene, looked[i], looked[other].image, {}, seen);
      exchanged.Add(difference, seen);
    }
    for (int side = 0; side < 2; ++side) {  // against the own image of the same views
      const size_t next = side == 0 ? i + 1 : i - 1;
      if (next >= looked.size() || looked[next].group != looked[i].group) continue;
      shifted[side].Add(ColorDifference(scene, looked[i], looked[next].image, {}, seen) - own,
                        seen);
    }
  }
  if (blind > 0)
    findings.push_back({2 * blind >= looked.size(),
                        std::to_string(blind) + " of " + std::to_string(looked.size()) +
                            " views looked at see none of the points (" + blind_name +
                            "): look at their poses, or the convention of their axes"});
  const Reading* better = nullptr;
  double min = kFitsBetter * given.mean();
  for (const Reading& reading : kReadings) {
    Fit fit;
    for (const LookedAt& one : looked) {
      size_t seen = 0;
      const double difference = ColorDifference(scene, one, one.image, reading, seen);
      fit.Add(difference, seen);
    }
    const bool enough = 2 * fit.pairs >= looked.size();
    if (enough && given.mean() > kMinGrey && fit.mean() < min) {
      min = fit.mean();
      better = &reading;
    }
  }
  const std::string figures = "the points' colours differ by " + Grey(given.mean()) +
                              " of 255 from the images where the cameras see them";
  if (better != nullptr) {
    findings.push_back({true,
                        figures + ", and by " + Grey(min) + " with " + better->what +
                            ": look at the cameras and images"});
    return;
  }
  for (int side = 0; side < 2; ++side)
    if (shifted[side].pairs >= 4 && given.mean() > kMinGrey &&
        shifted[side].mean() < -(1 - kFitsBetter) * given.mean()) {
      findings.push_back({true,
                          figures + ", and by " + Grey(given.mean() + shifted[side].mean()) +
                              " from the image of the " + (side == 0 ? "next" : "previous") +
                              " view: the images are shifted against their cameras"});
      return;
    }
  if (exchanged.pairs >= 3 && given.pairs >= 3 && given.mean() > kMinGrey &&
      given.mean() > kFitsNot * exchanged.mean() && 4 * in_place < 3 * given.pairs)
    findings.push_back({true,
                        figures + ", and by " + Grey(exchanged.mean()) +
                            " from those of other views: the images are not these cameras' "
                            "(exchanged or renamed), or poses or focal length are wrong"});
}

std::vector<LookedAt> LookAt(const std::vector<const SceneView*>& views,
                             std::vector<SkippedFrame>& skipped) {
  std::vector<LookedAt> looked;
  const size_t n = views.size(), groups = std::min(kGroups, std::max<size_t>(1, n / kNeighbours));
  for (size_t g = 0; g < groups; ++g) {
    const size_t last = n - std::min(n, kNeighbours),
                 first = groups == 1 ? 0 : g * last / (groups - 1);
    for (size_t i = first; i < std::min(n, first + kNeighbours); ++i) {
      LookedAt one;
      one.view = views[i];
      one.group = g;
      looked.push_back(std::move(one));
    }
  }
  std::vector<std::string> problems(looked.size());
  tbb::parallel_for(size_t(0), looked.size(), [&](size_t i) {
    LookedAt& one = looked[i];
    Image8 whole;
    problems[i] = Problem([&] {
      whole = LoadViewImage(*one.view);
      const Image8 ignored = LoadIgnored(*one.view);
      double sum = 0;
      for (const uint8_t value : ignored.data) sum += value;
      if (!ignored.data.empty()) one.ignored = sum / (255.0 * double(ignored.data.size()));
    });
    if (!problems[i].empty()) return;
    one.glance = GlanceOf(whole);
    one.image = ReducedTo(whole, kSide);
    one.camera = one.view->camera.Resized(one.image.width, one.image.height);
  });
  const auto name_of = [](const LookedAt& one) { return one.view->name; };
  return KeepUsable(std::move(looked), problems, name_of, skipped);
}

void CheckFit(const SceneData& scene,
              const std::vector<LookedAt>& looked,
              std::vector<Finding>& findings) {
  if (scene.point_colors.size() == scene.points.size() && HaveColors(scene))
    CheckColors(scene, looked, findings);
  else
    CheckSilhouettes(looked, findings);
}

}  // namespace cosplat

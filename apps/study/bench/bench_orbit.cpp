#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "apps/cosplat/run/camera_path.h"
#include "apps/cosplat/run/notes.h"
#include "apps/study/bench/bench_series.h"
#include "apps/study/bench/measure.h"
#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/config.h"
#include "splat/gaussians.h"
#include "splat/io/splat_file.h"
#include "splat/math/scalar.h"
#include "splat/render/rasterizer.h"

namespace cosplat {
namespace {

constexpr int kViews = 36;
constexpr float kFilled = 0.9f;                // share of the image's height
constexpr std::array<float, 3> kUp{0, -1, 0};  // as in most 3DGS and PlayCanvas files
constexpr float kHalfFieldOfView = 22.5f / 180 * 3.14159265f;  // vertical

using Point = std::array<float, 3>;

// Range of some values (at least one, which it reorders) without the outermost thousandth at either
// end. Splats are small: those outside are strays, not part of the subject.
struct Range {
  float low, high;
  float middle() const { return 0.5f * (low + high); }
  float length() const { return high - low; }
};
Range MostOf(std::vector<float>& values) {
  const auto at = [&](size_t thousandths) {
    const auto nth = values.begin() + long((values.size() - 1) * thousandths / 1000);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  return {at(1), at(999)};
}

std::vector<Point> VisiblePoints(const Gaussians& g) {
  const float min = math::Logit(kMinAlpha);
  std::vector<Point> points;
  for (size_t i = 0; i < g.size(); ++i) {
    const float* p = g.at(kPosition, i);
    if (*g.at(kOpacityLogit, i) >= min) points.push_back({p[0], p[1], p[2]});
  }
  return points;
}

// Extent of the points in the images, mean over the views.
struct Filling {
  float share = 0;         // of the image's height that they cover
  float above_middle = 0;  // offset of their middle above the image's, in image heights
};
Filling FillingOf(const std::vector<Point>& points, const std::vector<Camera>& cameras) {
  Filling mean;
  std::vector<float> rows(points.size());
  for (const Camera& c : cameras) {
    const auto& r = c.rotation;
    for (size_t i = 0; i < points.size(); ++i) {
      const Point& p = points[i];
      const float y = r[3] * p[0] + r[4] * p[1] + r[5] * p[2] + c.translation[1];
      const float z = r[6] * p[0] + r[7] * p[1] + r[8] * p[2] + c.translation[2];
      rows[i] = c.fy * y / std::max(z, c.near_plane);
    }
    const Range range = MostOf(rows);
    const float pixels = float(c.height) * float(cameras.size());
    mean.share += range.length() / pixels;
    mean.above_middle -= range.middle() / pixels;
  }
  return mean;
}

Camera Lens(bool quick) {
  Camera lens;
  const int divisor = quick ? 30 : 1;
  lens.width = 1920 / divisor;
  lens.height = 1080 / divisor;
  lens.fx = lens.fy = float(lens.height) / 2 / std::tan(kHalfFieldOfView);
  lens.cx = float(lens.width) / 2;
  lens.cy = float(lens.height) / 2;
  return lens;
}

// A full turn around `target`, at its height; the first camera is before it, at -z.
std::vector<Camera> OrbitTarget(Camera lens, const Point& target, float distance) {
  lens.translation = {-target[0], -target[1], distance - target[2]};
  std::vector<Camera> cameras;
  for (int i = 0; i < kViews; ++i)
    cameras.push_back(TurnedAround(lens, target, kUp, 360.0f * float(i) / kViews));
  return cameras;
}

// Points in front of the axis look larger than at the axis' distance, where the search starts.
std::vector<Camera> FittingOrbit(const std::string& path,
                                 const std::vector<Point>& points,
                                 const Camera& lens) {
  std::array<Range, 3> box;
  for (size_t k = 0; k < box.size(); ++k) {
    std::vector<float> values;
    for (const Point& p : points) values.push_back(p[k]);
    box[k] = MostOf(values);
  }
  if (!(box[1].length() > 0)) throw Error(path, "vertex", "the visible splats have zero height");
  Point target{box[0].middle(), box[1].middle(), box[2].middle()};
  // Stays outside the points, however flat they are.
  const float nearest = 0.6f * std::hypot(box[0].length(), box[2].length());
  float distance = std::max(nearest, lens.fy * box[1].length() / (kFilled * float(lens.height)));
  std::vector<Camera> cameras = OrbitTarget(lens, target, distance);
  constexpr int kSearchSteps = 5;  // the share is nearly inversely proportional to the distance
  for (int i = 0; i < kSearchSteps; ++i) {
    const Filling filling = FillingOf(points, cameras);
    const float height = float(lens.height) / lens.fy * distance;  // of the image, at the axis
    for (size_t k = 0; k < target.size(); ++k) target[k] += kUp[k] * filling.above_middle * height;
    distance = std::max(nearest, distance * filling.share / kFilled);
    cameras = OrbitTarget(lens, target, distance);
  }
  return cameras;
}

// Fastest of several rounds over all views, after a warm-up round.
struct ViewTime {
  double seconds = std::numeric_limits<double>::infinity();
  PhaseTimes phases;
};
std::vector<ViewTime> TimeViews(const OrbitSubject& subject, int rounds, RenderedImage& first) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const RenderSettings settings{{0, 0, 0}, subject.gaussians.degree};
  const WorldGaussians view = ViewOf(subject.gaussians);
  std::vector<ViewTime> times(subject.cameras.size());
  RenderedImage image;
  for (int round = -1; round < rounds; ++round)
    for (size_t i = 0; i < times.size(); ++i) {
      rasterizer->times = {};
      const auto start = std::chrono::steady_clock::now();
      rasterizer->Forward(
          view, subject.gaussians.basis, subject.cameras[i], settings, image, *tape);
      const double seconds = SecondsSince(start);
      if (i == 0) first = image;
      if (round >= 0 && seconds < times[i].seconds) times[i] = {seconds, rasterizer->times};
    }
  return times;
}

OrderedJson PhaseMs(const std::vector<ViewTime>& times) {
  PhaseTimes sum;
  for (const ViewTime& time : times) sum += time.phases;
  OrderedJson json;
  for (const Phase phase : {Phase::kProject, Phase::kSort, Phase::kBlend})
    json[kPhaseNames[size_t(phase)]] = 1e3 * sum.seconds[size_t(phase)] / double(times.size());
  return json;
}

}  // namespace

OrbitSubject LoadOrbit(const std::string& path, bool quick) {
  OrbitSubject subject;
  subject.name = std::filesystem::path(path).filename().string();
  subject.gaussians = ReadSplatsAloud(path);
  SortByDegree(subject.gaussians);
  const std::vector<Point> points = VisiblePoints(subject.gaussians);
  if (points.empty()) throw Error(path, "vertex", "no splat is visible");
  subject.cameras = FittingOrbit(path, points, Lens(quick));
  return subject;
}

OrbitResult MeasureOrbit(const BenchRun& run, const OrbitSubject& subject) {
  using tbb::global_control;
  run.progress("orbit around " + subject.name);
  RenderedImage first;
  const std::vector<ViewTime> times = TimeViews(subject, run.quick ? 1 : 3, first);
  std::vector<Mark> marks;
  double seconds = 0;
  for (const ViewTime& time : times) {
    seconds += time.seconds;
    marks.push_back({double(marks.size() + 1), 1e3 * time.seconds, ""});
  }
  const double mean_ms = 1e3 * seconds / double(times.size());
  const std::string size = SizeText(first.width, first.height);
  BenchSeries s;
  s.key = "orbit";
  s.explanation = "Frame time of " + subject.name + " at " + size +
                  " from views 10 degrees apart, its height filling 90 % of the image's; dashed "
                  "their mean.";
  s.statistic = "fastest round of each view";
  s.chart = {Chart::Kind::kLines,
             "Orbit around " + subject.name,
             {"view, 10 degrees apart", ""},
             {"frame", "ms"},
             {},
             {}};
  s.chart.series = {{WithThousands(subject.gaussians.size()) + " splats", marks}};
  char mean[48];
  std::snprintf(mean, sizeof mean, "mean: %.1f frames/s", 1e3 / mean_ms);
  s.chart.guides = {{mean, {{1, mean_ms, ""}, {double(times.size()), mean_ms, ""}}}};
  s.more = {{"frames_per_second", 1e3 / mean_ms},
            {"splats", subject.gaussians.size()},
            {"threads", global_control::active_value(global_control::max_allowed_parallelism)},
            {"width", first.width},
            {"height", first.height},
            {"phase_ms", PhaseMs(times)}};
  return {std::move(s), first.ToImage()};
}

}  // namespace cosplat

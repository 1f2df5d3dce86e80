#include "flame/fit/face_texture.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "flame/fit/points_on_flame.h"

namespace cosplat::internal {
namespace {

constexpr int kSamples = 2000;
// Every so many samples, one is held out.
constexpr int kHoldOutEvery = 4;
// A point is visible where its normal is less than some 70 degrees from the viewer.
constexpr double kMinFacing = 0.3;
// Deviation of brightness beside a point's own variation over the video, in 8-bit levels: noise,
// and what interpolation makes of fine detail.
constexpr double kNoise = 4;
// Neighbouring points' errors are alike, so that each counts less than one on its own.
constexpr double kIndependence = 0.5;
// Frames in which a point must be visible, counted by how well.
constexpr double kMinFrames = 3;
// What a round must gain for there to be another.
constexpr double kMinGain = 0.01;

double AreaOf(const FlameModel& model, const std::array<int32_t, 3>& face) {
  using Point = Eigen::Map<const Eigen::Vector3f>;
  const Point a(&model.template_vertices[3 * size_t(face[0])]),
      b(&model.template_vertices[3 * size_t(face[1])]),
      c(&model.template_vertices[3 * size_t(face[2])]);
  return (b - a).cross(c - a).norm() / 2;
}

// Triangles' centres, evenly over the area of the skin, which eyes and an added mouth are not.
LandmarkEmbedding SampleSkin(const FlameModel& model) {
  std::vector<double> until;  // sums of the areas
  double total = 0;
  const std::vector<std::array<int32_t, 3>> faces = SkinFaces(model);
  for (const auto& face : faces) until.push_back(total += AreaOf(model, face));
  LandmarkEmbedding out;
  size_t t = 0;
  for (int k = 0; k < kSamples && total > 0; ++k) {
    while (t + 1 < until.size() && until[t] < (k + 0.5) / kSamples * total) ++t;
    const auto& face = faces[t];
    out.push_back({k, {face[0], face[1], face[2]}, {1.0 / 3, 1.0 / 3, 1.0 / 3}});
  }
  return out;
}

LandmarkEmbedding CornersOf(const LandmarkEmbedding& samples) {
  LandmarkEmbedding out;
  for (EmbeddedLandmark corner : samples)
    for (size_t k = 0; k < 3; ++k) {
      corner.barycentric = {};
      corner.barycentric[k] = 1;
      out.push_back(corner);
    }
  return out;
}

struct MeanBrightness {
  double mean = 0, spread = 0;
  bool known = false;
};

// Mean and standard deviation with the weights of a Cauchy distribution, so that frames in which
// something covers the point do not count. values: brightness and weight.
MeanBrightness RobustMean(const std::vector<std::array<double, 2>>& values) {
  constexpr int kPasses = 6;
  MeanBrightness out;
  double inverse = 0;  // of twice the spread; first, all count alike
  for (int pass = 0; pass < kPasses; ++pass) {
    double sum = 0, squares = 0, weights = 0;
    for (const auto& [value, weight] : values) {
      const double q = (value - out.mean) * inverse;
      const double w = weight / (1 + q * q);
      sum += w * value;
      squares += w * value * value;
      weights += w;
    }
    if (weights < kMinFrames) return out;
    out.mean = sum / weights;
    out.spread = std::sqrt(std::max(0.0, squares / weights - out.mean * out.mean));
    inverse = 0.5 / std::max(out.spread, 1e-6);
  }
  out.known = true;
  return out;
}

}  // namespace

FaceTexture::FaceTexture(const FlameModel& model,
                         int shape_count,
                         int expression_count,
                         const std::vector<std::optional<FrameView>>& views,
                         const std::vector<FrameFields>& fields)
    : views_(views),
      fields_(fields),
      points_(model, SampleSkin(model), shape_count, expression_count),
      corners_(model, CornersOf(SampleSkin(model)), shape_count, expression_count) {}

std::vector<FaceTexture::Seen> FaceTexture::See(const std::vector<double>& shape,
                                                double log_focal,
                                                const std::vector<double>& frame,
                                                size_t f) const {
  PointsOnFlame::Tape points, corners;
  points_.Pose(shape.data(), frame.data(), points);
  corners_.Pose(shape.data(), frame.data(), corners);
  const FrameView& view = *views_[f];
  std::vector<Seen> seen(points.points.size());
  for (size_t p = 0; p < seen.size(); ++p) {
    const auto place = [&](const std::array<double, 3>& point) {
      const auto [x, y, z] = InView(view, point);
      return Eigen::Vector3d(x, y, z);
    };
    const Eigen::Vector3d at = place(points.points[p]), a = place(corners.points[3 * p]),
                          b = place(corners.points[3 * p + 1]),
                          c = place(corners.points[3 * p + 2]);
    const double facing = -(b - a).cross(c - a).normalized().dot(at.normalized());
    if (!(facing > kMinFacing) || !(at[2] < 0)) continue;
    const double scale = std::exp(log_focal) / -at[2];
    const FieldAt brightness =
        SampleAt(fields_[f].brightness, view.lens.cx + scale * at[0], view.lens.cy - scale * at[1]);
    if (brightness.inside) seen[p] = {brightness.value, facing};
  }
  return seen;
}

void FaceTexture::Measure(const std::vector<double>& shape,
                          double log_focal,
                          const std::vector<std::vector<double>>& frames) {
  std::vector<std::vector<Seen>> seen(frames.size());
  tbb::parallel_for(size_t(0), frames.size(), [&](size_t f) {
    if (!frames[f].empty()) seen[f] = See(shape, log_focal, frames[f], f);
  });
  shape_ = shape;
  visible_.assign(frames.size(), {});
  double held_out = 0, held_out_points = 0;
  for (int p = 0; p < points_.point_count(); ++p) {
    std::vector<std::array<double, 2>> values;
    for (const auto& frame : seen)
      if (!frame.empty() && frame[size_t(p)].facing > 0)
        values.push_back({frame[size_t(p)].value, std::pow(frame[size_t(p)].facing, 2)});
    const MeanBrightness brightness = RobustMean(values);
    if (!brightness.known) continue;
    if (p % kHoldOutEvery == 0) {
      held_out += brightness.spread;
      ++held_out_points;
      continue;
    }
    const double sigma = std::hypot(brightness.spread, kNoise) / kIndependence;
    for (size_t f = 0; f < frames.size(); ++f)
      if (!seen[f].empty() && seen[f][size_t(p)].facing > 0)
        visible_[f].push_back({p, brightness.mean, sigma / seen[f][size_t(p)].facing});
  }
  held_out_spread_ = held_out / held_out_points;
}

std::vector<double> FaceTexture::Refine(const std::vector<double>& shape,
                                        double log_focal,
                                        std::vector<std::vector<double>>& frames,
                                        const std::function<void()>& fit_frames) {
  Measure(shape, log_focal, frames);
  std::vector<double> spread{held_out_spread_};
  for (int round = 0; round < kMaxPhotometricRounds; ++round) {
    const std::vector<std::vector<double>> before = frames;
    fit_frames();
    Measure(shape, log_focal, frames);
    if (!(held_out_spread_ < spread.back())) {
      frames = before;
      break;
    }
    spread.push_back(held_out_spread_);
    if (held_out_spread_ > (1 - kMinGain) * spread[spread.size() - 2]) break;
  }
  return spread;
}

std::unique_ptr<FieldCost> FaceTexture::Cost(size_t f) const {
  if (!measured() || visible_[f].empty()) return nullptr;
  std::vector<FieldPoint> visible = visible_[f];
  std::vector<int> points;
  for (FieldPoint& point : visible) {
    points.push_back(point.point);
    point.point = int(points.size()) - 1;
  }
  auto part = std::make_shared<const PointsOnFlame>(points_.Part(points, shape_.data()));
  return std::make_unique<FieldCost>(
      std::move(part), std::move(visible), fields_[f].brightness, *views_[f], int(shape_.size()));
}

}  // namespace cosplat::internal

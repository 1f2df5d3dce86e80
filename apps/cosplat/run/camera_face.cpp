#include "apps/cosplat/run/camera_face.h"

#include <Eigen/Geometry>
#include <cmath>

#include "flame/fit/landmark_scores.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

constexpr size_t kPoints = 478;
constexpr size_t kRightCorner = 33, kLeftCorner = 263;
// Forehead, bridge and tip of the nose, corners of the eyes, temples, before the ears.
constexpr size_t kRigid[] = {10,  151, 9,   8,   168, 6,   197, 195, 5,  4,   33,  133,
                             263, 362, 127, 356, 234, 454, 21,  251, 54, 284, 162, 389};
constexpr double kEyeCorners = 0.09;  // metres between the outer corners of an adult's eyes
constexpr double kFieldOfView = 1.1;  // radians, of the image's height
// From the joint of the neck to the mean of the rigid points of a face, metres, FLAME's axes.
const Eigen::Vector3d kFromNeck(0, 0.1, 0.08);
// At rest a delay of 32 ms; fast lids and lips are hardly filtered.
constexpr math::OneEuro kFilter{5, 4, 5};
constexpr double kLongestStep = 0.5;  // seconds; after a longer one the filter begins again

using Points = Eigen::Matrix3Xd;

Points ColumnsOf(const std::vector<std::array<double, 3>>& points) {
  Points columns(3, Eigen::Index(points.size()));
  for (size_t i = 0; i < points.size(); ++i)
    columns.col(Eigen::Index(i)) = Eigen::Map<const Eigen::Vector3d>(points[i].data());
  return columns;
}

size_t ScoreCount() {
  DetectedFace face;
  face.points.assign(kPoints, {});
  face.points[kLeftCorner] = {2, 0};
  return ScoresOf(face, LandmarkSet::kMediapipe478).size();
}

}  // namespace

CameraFrame ParseCameraFrame(const std::string& line) {
  const JsonField field("the camera's program", ParseJson("the camera's program", line));
  CameraFrame frame;
  frame.camera = field["camera"].String();
  frame.width = field["width"].Integer(1, 1 << 15);
  frame.height = field["height"].Integer(1, 1 << 15);
  frame.seconds = field["time"].Number() / 1000;
  frame.milliseconds = field["milliseconds"].Number();
  if (field.Has("bar")) frame.bar = field["bar"].Integer(0, 1 << 12);
  const JsonField points = field["points"];
  if (points.size() != 0 && points.size() != kPoints) points.Fail("has not 478 points");
  for (size_t i = 0; i < points.size(); ++i)
    frame.points.push_back({points[i][0].Number(), points[i][1].Number(), points[i][2].Number()});
  return frame;
}

CameraFace::CameraFace() : smoother_(ScoreCount()) {}

CameraFace::Head CameraFace::HeadIn(const CameraFrame& frame) {
  const auto at = [&](size_t point) -> std::array<double, 3> {
    const auto& [x, y, z] = frame.points[point];
    return {x - 0.5 * frame.width, 0.5 * frame.height - y, -z};
  };
  Head head;
  for (const size_t point : kRigid) head.points.push_back(at(point));
  const auto right = at(kRightCorner), left = at(kLeftCorner);
  head.eyes = std::hypot(left[0] - right[0], left[1] - right[1], left[2] - right[2]);
  return head;
}

void CameraFace::AddNeutral(const Head& head) {
  if (neutral_frames_ == 0) neutral_ = {std::vector<std::array<double, 3>>(head.points.size()), 0};
  constexpr double kShare = 1.0 / kNeutralFrames;
  for (size_t i = 0; i < head.points.size(); ++i)
    for (size_t k = 0; k < 3; ++k) neutral_.points[i][k] += kShare * head.points[i][k];
  neutral_.eyes += kShare * head.eyes;
  ++neutral_frames_;
}

FlameParams CameraFace::MotionOf(const Head& head, const CameraFrame& frame) const {
  const Points from = ColumnsOf(neutral_.points), to = ColumnsOf(head.points);
  const Eigen::Matrix3d scaled = Eigen::umeyama(from, to, true).topLeftCorner<3, 3>();
  const double scale = std::cbrt(scaled.determinant());
  const Eigen::Matrix3d turn = scaled / scale;
  // A weak perspective: all of a face has one distance, which is the focal length times the metres
  // that a pixel is there.
  const double focal = 0.5 * frame.height / std::tan(kFieldOfView / 2);
  const auto place = [&](const Points& points, double metres) {
    Eigen::Vector3d p = metres * points.rowwise().mean();
    p.z() = -focal * metres;
    return p;
  };
  const double metres = kEyeCorners / neutral_.eyes;
  const Eigen::Vector3d shift =
      place(to, metres / scale) - place(from, metres) - (turn * kFromNeck - kFromNeck);
  FlameParams params;
  const Eigen::AngleAxisd axis(turn);
  for (int k = 0; k < 3; ++k) {
    params.pose[0][size_t(k)] = float(axis.angle() * axis.axis()[k]);
    params.translation[size_t(k)] = float(shift[k]);
  }
  return params;
}

std::optional<JsonFrame> CameraFace::Next(const CameraFrame& frame) {
  if (frame.width != width_ || frame.height != height_) Calibrate();
  width_ = frame.width, height_ = frame.height;
  if (frame.points.empty()) return {};
  DetectedFace face;
  for (const auto& [x, y, z] : frame.points) face.points.push_back({x, y});
  BlendshapeScores scores = ScoresOf(face, LandmarkSet::kMediapipe478);
  const Head head = HeadIn(frame);
  if (scores.empty() || head.eyes == 0) return {};  // too small
  if (!IsCalibrated()) {
    AddNeutral(head);
    return {};
  }
  FlameParams motion = MotionOf(head, frame);
  for (const auto& [name, score] : scores) motion.expression.push_back(score);
  const double step = last_ ? frame.seconds - *last_ : -1;
  if (step < 0 || step > kLongestStep) smoother_.Reset();
  smoother_.Smooth(kFilter, float(step), motion);
  last_ = frame.seconds;
  size_t i = 0;
  for (auto& [name, score] : scores) score = motion.expression[i++];
  motion.expression.clear();
  return JsonFrame{sequence_++, frame.seconds, std::move(motion), std::move(scores), {}};
}

}  // namespace cosplat

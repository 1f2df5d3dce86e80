#include "apps/study/face_points/cast_points.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "flame/fit/points_on_flame.h"
#include "flame/pose.h"
#include "splat/base/error.h"
#include "splat/base/median.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr size_t kCastFrames = 120;  // of a video, evenly chosen
constexpr size_t kMinFrames = 3;
// A ray that meets the skin further from the model's point has met another part of the head.
constexpr double kCastReach = 0.025;  // metres
constexpr double kMinFacing = 0.4;    // cosine between normal and viewer

bool IsOnEye(const FlameModel& model, const EmbeddedLandmark& point) {
  const float* const weights = &model.skinning_weights[kFlameJoints * size_t(point.vertices[0])];
  return weights[3] + weights[4] > 0.5f;
}

Vector3d VertexOf(const std::vector<float>& vertices, int32_t v) {
  return Eigen::Map<const Eigen::Vector3f>(&vertices[3 * size_t(v)]).cast<double>();
}

Vector3d PlaceOf(const std::vector<float>& vertices, const EmbeddedLandmark& point) {
  Vector3d place = Vector3d::Zero();
  for (size_t k = 0; k < 3; ++k)
    place += point.barycentric[k] * VertexOf(vertices, point.vertices[k]);
  return place;
}

// A frame's mesh as its camera sees it.
class SeenMesh {
 public:
  SeenMesh(const FlameModel& model, const std::vector<float>& vertices, const Camera& camera)
      : model_(model) {
    const Eigen::Matrix3f rotation =
        Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(camera.rotation.data());
    const Eigen::Vector3f shift = Eigen::Map<const Eigen::Vector3f>(camera.translation.data());
    for (size_t i = 0; i < vertices.size(); i += 3) {
      const Vector3d p =
          (rotation * Eigen::Map<const Eigen::Vector3f>(&vertices[i]) + shift).cast<double>();
      points_.push_back(p);
      pixels_.emplace_back(camera.cx + camera.fx * p[0] / p[2],
                           camera.cy + camera.fy * p[1] / p[2]);
    }
  }

  // The template's place that the ray through `pixel` meets first; beside a lid's edge, on the eye.
  std::optional<Vector3d> Cast(const Vector2d& pixel, const EmbeddedLandmark& near) const {
    Vector3d expected = Vector3d::Zero();
    for (size_t k = 0; k < 3; ++k)
      expected += near.barycentric[k] * points_[size_t(near.vertices[k])];
    std::optional<Vector3d> place;
    double depth = HUGE_VAL;
    for (const auto& [a, b, c] : model_.faces) {
      const auto weights = WeightsIn(pixel, size_t(a), size_t(b), size_t(c));
      if (!weights) continue;
      const auto mixed = [&](const Vector3d& x, const Vector3d& y, const Vector3d& z) -> Vector3d {
        return (*weights)[0] * x + (*weights)[1] * y + (*weights)[2] * z;
      };
      const Vector3d &pa = points_[size_t(a)], &pb = points_[size_t(b)], &pc = points_[size_t(c)];
      const Vector3d at = mixed(pa, pb, pc);
      const double facing = -(pb - pa).cross(pc - pa).normalized().dot(at.normalized());
      if (!(facing > 0) || !(at[2] > 0) || at[2] >= depth) continue;
      depth = at[2];
      place.reset();
      if (facing > kMinFacing && (at - expected).norm() < kCastReach)
        place = mixed(VertexOf(model_.template_vertices, a),
                      VertexOf(model_.template_vertices, b),
                      VertexOf(model_.template_vertices, c));
    }
    return place;
  }

 private:
  // Barycentric weights in the image, whose difference from those on the triangle does not count at
  // a triangle's size.
  std::optional<std::array<double, 3>> WeightsIn(const Vector2d& p,
                                                 size_t a,
                                                 size_t b,
                                                 size_t c) const {
    const Vector2d u = pixels_[b] - pixels_[a], v = pixels_[c] - pixels_[a], d = p - pixels_[a];
    const double area = u[0] * v[1] - u[1] * v[0];
    if (area == 0) return {};
    const double wb = (d[0] * v[1] - d[1] * v[0]) / area, wc = (u[0] * d[1] - u[1] * d[0]) / area;
    if (!(wb >= 0 && wc >= 0 && wb + wc <= 1)) return {};
    return std::array<double, 3>{1 - wb - wc, wb, wc};
  }

  const FlameModel& model_;
  std::vector<Vector3d> points_;
  std::vector<Vector2d> pixels_;
};

std::optional<std::array<double, 3>> MedianOf(const std::vector<Vector3d>& hits) {
  if (hits.size() < kMinFrames) return {};
  std::array<double, 3> median;
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vector3d& hit : hits) values.push_back(hit[long(axis)]);
    median[axis] = Median(values);
  }
  return median;
}

Vector3d Mirrored(const Vector3d& p) { return {-p[0], p[1], p[2]}; }

// Per landmark, that of the other side; itself in the median plane. The mouth is open, so that
// points of both lips are apart.
std::vector<size_t> OtherSides(const FlameModel& model) {
  FlamePoser<float>::Parameters open;
  open.pose[2] = {0.3f, 0, 0};
  std::vector<float> vertices;
  FlamePoser<float>(model, {}).Forward(open, vertices);
  std::vector<Vector3d> places;
  for (const EmbeddedLandmark& point : model.landmarks) places.push_back(PlaceOf(vertices, point));
  std::vector<size_t> other;
  for (const Vector3d& place : places) {
    const auto distance = [&](const Vector3d& p) { return (p - Mirrored(place)).squaredNorm(); };
    const auto nearest =
        std::min_element(places.begin(), places.end(), [&](const Vector3d& a, const Vector3d& b) {
          return distance(a) < distance(b);
        });
    other.push_back(size_t(nearest - places.begin()));
  }
  return other;
}

// The point of the skin that is nearest to `at`, by the weights of its projection onto a triangle's
// plane, moved into the triangle.
EmbeddedLandmark NearestOnSkin(const FlameModel& model,
                               const std::vector<std::array<int32_t, 3>>& faces,
                               const Vector3d& at,
                               EmbeddedLandmark point) {
  double min = HUGE_VAL;
  for (const auto& face : faces) {
    const Vector3d a = VertexOf(model.template_vertices, face[0]);
    const Vector3d u = VertexOf(model.template_vertices, face[1]) - a;
    const Vector3d v = VertexOf(model.template_vertices, face[2]) - a;
    Eigen::Matrix<double, 3, 2> sides;
    sides << u, v;
    const Vector2d w = (sides.transpose() * sides).ldlt().solve(sides.transpose() * (at - a));
    Vector3d weights(1 - w.sum(), w[0], w[1]);
    weights = weights.cwiseMax(0);
    weights /= weights.sum();
    const double distance = (a + weights[1] * u + weights[2] * v - at).norm();
    if (!(distance < min)) continue;
    min = distance;
    point.vertices = {face[0], face[1], face[2]};
    point.barycentric = {weights[0], weights[1], weights[2]};
  }
  return point;
}

}  // namespace

CastPlaces CastPoints(const FlameModel& model, TrackedVideo& video, const LandmarkVideo& marks) {
  std::map<std::string, const LandmarkFrame*> by_name;
  for (const LandmarkFrame& frame : marks.frames) by_name[frame.name] = &frame;
  std::vector<std::pair<const TrackedFrame*, const DetectedFace*>> both;
  for (const TrackedFrame* frame : FramesInOrder(video)) {
    const auto found = by_name.find(frame->name);
    if (found == by_name.end() || found->second->faces.size() != 1) continue;
    both.emplace_back(frame, &found->second->faces[0]);
  }
  if (both.size() < kMinFrames)
    throw Error(marks.file,
                Format("{} frames of '{}' have one face here, expected at least {}",
                       both.size(),
                       video.source,
                       kMinFrames));
  const Camera& camera = both[0].first->camera;
  if (camera.width != marks.width || camera.height != marks.height)
    throw Error(marks.file,
                Format("is of images of {}x{}, '{}' of {}x{}",
                       marks.width,
                       marks.height,
                       video.source,
                       camera.width,
                       camera.height));
  const size_t count = std::min(kCastFrames, both.size());
  std::vector<CastPlaces> hits(count, CastPlaces(model.landmarks.size()));
  tbb::parallel_for(size_t(0), count, [&](size_t i) {
    const auto& [frame, face] = both[i * both.size() / count];
    const SeenMesh mesh(model, TrackedVertices(model, video, *frame), frame->camera);
    for (size_t p = 0; p < model.landmarks.size(); ++p) {
      const size_t landmark = size_t(model.landmarks[p].landmark);
      if (landmark >= face->points.size() || IsOnEye(model, model.landmarks[p])) continue;
      const auto [x, y] = face->points[landmark];
      if (const auto hit = mesh.Cast({x, y}, model.landmarks[p]))
        hits[i][p] = {(*hit)[0], (*hit)[1], (*hit)[2]};
    }
  });
  CastPlaces places;
  for (size_t p = 0; p < model.landmarks.size(); ++p) {
    std::vector<Vector3d> seen;
    for (const CastPlaces& frame : hits)
      if (frame[p]) seen.emplace_back(frame[p]->data());
    places.push_back(MedianOf(seen));
  }
  const long cast =
      std::count_if(places.begin(), places.end(), [](const auto& at) { return bool(at); });
  if (cast < long(places.size() / 2))
    throw Error(marks.file,
                Format("{} of {} points meet the head of '{}': landmarks of another video?",
                       cast,
                       places.size(),
                       video.source));
  return places;
}

PlacedPoints PlaceOnSkin(const FlameModel& model, const std::vector<CastPlaces>& people) {
  const size_t count = model.landmarks.size();
  const std::vector<std::array<int32_t, 3>> faces = SkinFaces(model);
  std::vector<Vector3d> given;
  for (const EmbeddedLandmark& point : model.landmarks)
    given.push_back(PlaceOf(model.template_vertices, point));
  std::vector<Vector3d> mean = given;
  std::vector<bool> seen(count);
  PlacedPoints out;
  double people_squares = 0, people_count = 0, symmetry_squares = 0;
  for (size_t p = 0; p < count; ++p) {
    std::vector<Vector3d> places;
    for (const CastPlaces& person : people)
      if (person.at(p)) places.emplace_back(person[p]->data());
    if (places.empty()) continue;
    seen[p] = true;
    mean[p].setZero();
    for (const Vector3d& place : places) mean[p] += place / double(places.size());
    for (const Vector3d& place : places) people_squares += (place - mean[p]).squaredNorm();
    people_count += double(places.size());
  }
  const std::vector<size_t> other = OtherSides(model);
  for (size_t p = 0; p < count; ++p) {
    const bool both = seen[p] && seen[other[p]] && other[other[p]] == p;
    const Vector3d place = both ? Vector3d((mean[p] + Mirrored(mean[other[p]])) / 2) : mean[p];
    out.places.push_back({place[0], place[1], place[2]});
    EmbeddedLandmark point = model.landmarks[p];
    if (seen[p]) {
      point = NearestOnSkin(model, faces, place, point);
      ++out.seen;
      out.moved += (place - given[p]).squaredNorm();
      symmetry_squares += (place - mean[p]).squaredNorm();
    }
    out.landmarks.push_back(point);
  }
  out.moved = std::sqrt(out.moved / std::max(out.seen, 1));
  out.people = std::sqrt(people_squares / std::max(people_count, 1.0));
  out.symmetry = std::sqrt(symmetry_squares / std::max(out.seen, 1));
  return out;
}

}  // namespace cosplat

#include "flame/fit/silhouette.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "flame/fit/points_on_flame.h"

namespace cosplat::internal {
namespace {

// Standard deviation of the outline's distance from the rim, as a fraction of the face's size.
constexpr double kRimSigma = 0.012;
// In units of the face's size: how far inside the rim the outline is still drawn to it. Ears under
// hair are further.
constexpr double kNear = 0.1;
// In units of the face's size: at most one point per square of this side, and how far outside the
// outline nothing of the mesh may be.
constexpr double kCell = 0.06, kOutside = 0.01;

std::vector<int32_t> VerticesOf(const std::vector<std::array<int32_t, 3>>& faces) {
  std::set<int32_t> vertices;
  for (const auto& face : faces) vertices.insert(face.begin(), face.end());
  return {vertices.begin(), vertices.end()};
}

using Triangle = std::array<Eigen::Vector2d, 3>;

std::array<int, 2> SquareOf(const Eigen::Vector2d& at, double side) {
  return {int(std::floor(at[0] / side)), int(std::floor(at[1] / side))};
}

bool Contains(const Triangle& triangle, const Eigen::Vector2d& at) {
  const auto side = [&](int from, int to) {
    const Eigen::Vector2d edge = triangle[to] - triangle[from], place = at - triangle[from];
    return edge[0] * place[1] - edge[1] * place[0];
  };
  const double a = side(0, 1), b = side(1, 2), c = side(2, 0);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

EmbeddedLandmark PointBetween(int32_t a, int32_t b, double toward_b) {
  return {0, {a, b, b}, {1 - toward_b, toward_b, 0}};
}

// Above the eyes, hair may stand out from the head.
std::vector<bool> MayHaveHair(const FlameModel& model) {
  constexpr size_t kLeftEye = 3;
  const size_t count = size_t(model.vertex_count);
  double eyes = 0;
  for (size_t v = 0; v < count; ++v)
    eyes += model.joint_regressor[kLeftEye * count + v] * model.template_vertices[3 * v + 1];
  std::vector<bool> above(count);
  for (size_t v = 0; v < count; ++v) above[v] = model.template_vertices[3 * v + 1] > eyes;
  return above;
}

LandmarkEmbedding EmbeddingOf(const std::vector<int32_t>& vertices) {
  LandmarkEmbedding out;
  for (int32_t v : vertices) out.push_back(PointBetween(v, v, 0));
  return out;
}

// Which places of the image the triangles cover; each is listed in the squares that it may reach.
class Coverage {
 public:
  explicit Coverage(double square) : square_(square) {}
  void Add(const Triangle& triangle) {
    std::array<int, 2> low, high;
    for (int k = 0; k < 2; ++k) {
      const auto [min, max] = std::minmax({triangle[0][k], triangle[1][k], triangle[2][k]});
      low[k] = int(std::floor(min / square_)), high[k] = int(std::floor(max / square_));
    }
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) squares_[{x, y}].push_back(triangle);
  }
  bool Covers(const Eigen::Vector2d& at) const {
    const auto found = squares_.find(SquareOf(at, square_));
    return found != squares_.end() &&
           std::any_of(found->second.begin(), found->second.end(), [&](const Triangle& triangle) {
             return Contains(triangle, at);
           });
  }

 private:
  const double square_;
  std::map<std::array<int, 2>, std::vector<Triangle>> squares_;
};

}  // namespace

// The vertices' places in the image, x right and y down, and normals in the camera's axes.
struct Silhouette::Posed {
  std::vector<Eigen::Vector2d> image;
  std::vector<Eigen::Vector3d> normal;
  std::vector<double> facing;  // cosine between normal and viewer, times the triangles' area
  std::vector<double> pixels_per_metre;
};

Silhouette::Silhouette(const FlameModel& model, int shape_count, int expression_count)
    : model_(model),
      shape_count_(shape_count),
      expression_count_(expression_count),
      faces_(SkinFaces(model)),
      may_have_hair_(MayHaveHair(model)),
      place_(size_t(model.vertex_count), -1),
      surface_(model, EmbeddingOf(VerticesOf(faces_)), shape_count, expression_count) {
  int32_t next = 0;
  for (int32_t v : VerticesOf(faces_)) place_[size_t(v)] = next++;
  std::map<std::array<int32_t, 2>, int> triangles;
  for (const auto& face : faces_)
    for (size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(face[k], face[(k + 1) % 3]);
      ++triangles[{a, b}];
    }
  for (const auto& [vertices, count] : triangles) edges_.push_back({vertices, count == 1});
}

Silhouette::Posed Silhouette::PosedIn(const double* shape,
                                      double log_focal,
                                      const double* frame,
                                      const FrameView& view) const {
  PointsOnFlame::Tape tape;
  surface_.Pose(shape, frame, tape);
  const size_t count = tape.points.size();
  Posed posed;
  std::vector<Eigen::Vector3d> at(count);
  for (size_t p = 0; p < count; ++p) {
    const std::array<double, 3> point = InView(view, tape.points[p]);
    if (-point[2] < kMinDistance) return {};
    at[p] = {point[0], point[1], point[2]};
    const double scale = std::exp(log_focal) / -point[2];
    posed.pixels_per_metre.push_back(scale);
    posed.image.emplace_back(view.lens.cx + scale * point[0], view.lens.cy - scale * point[1]);
  }
  posed.normal.assign(count, Eigen::Vector3d::Zero());
  for (const auto& face : faces_) {
    const size_t a = size_t(place_[size_t(face[0])]), b = size_t(place_[size_t(face[1])]),
                 c = size_t(place_[size_t(face[2])]);
    const Eigen::Vector3d normal = (at[b] - at[a]).cross(at[c] - at[a]);
    for (size_t v : {a, b, c}) posed.normal[v] += normal;
  }
  for (size_t p = 0; p < count; ++p)
    posed.facing.push_back(-posed.normal[p].dot(at[p].normalized()));
  return posed;
}

std::vector<OutlinePoint> Silhouette::Outline(const double* shape,
                                              double log_focal,
                                              const double* frame,
                                              const FrameField& rim,
                                              const FrameView& view) const {
  const Posed posed = PosedIn(shape, log_focal, frame, view);
  if (posed.image.empty()) return {};
  const double cell = kCell * view.face_size;
  Coverage coverage(cell);
  for (const auto& face : faces_)
    coverage.Add({posed.image[size_t(place_[size_t(face[0])])],
                  posed.image[size_t(place_[size_t(face[1])])],
                  posed.image[size_t(place_[size_t(face[2])])]});
  std::vector<OutlinePoint> outline;
  std::set<std::array<int, 2>> taken;
  for (const Edge& edge : edges_) {
    const auto& [i, j] = edge.vertices;
    const size_t a = size_t(place_[size_t(i)]), b = size_t(place_[size_t(j)]);
    const double facing = posed.facing[a], other = posed.facing[b];
    if (!edge.border && (facing > 0) == (other > 0)) continue;
    const double toward_b = edge.border ? 0.5 : facing / (facing - other);
    const Eigen::Vector2d at = posed.image[a] + toward_b * (posed.image[b] - posed.image[a]);
    const FieldAt distance = SampleAt(rim, at[0], at[1]);
    if (!distance.inside || taken.count(SquareOf(at, cell))) continue;
    if (!edge.border) {
      const Eigen::Vector3d normal =
          posed.normal[a] + toward_b * (posed.normal[b] - posed.normal[a]);
      const Eigen::Vector2d out = Eigen::Vector2d(normal[0], -normal[1]).normalized();
      if (coverage.Covers(at + kOutside * view.face_size * out)) continue;
    }
    taken.insert(SquareOf(at, cell));
    outline.push_back({edge.vertices,
                       toward_b,
                       distance.value,
                       posed.pixels_per_metre[a],
                       edge.border || may_have_hair_[size_t(i)]});
  }
  return outline;
}

std::unique_ptr<FieldCost> Silhouette::Cost(const double* shape,
                                            double log_focal,
                                            const double* frame,
                                            const FrameField& rim,
                                            const FrameView& view) const {
  LandmarkEmbedding embedding;
  std::vector<FieldPoint> points;
  for (const OutlinePoint& point : Outline(shape, log_focal, frame, rim, view)) {
    const double min = point.more_in_matte ? 0 : -kNear * view.face_size;
    if (!(point.distance > min)) continue;
    points.push_back({int(points.size()), 0, kRimSigma * view.face_size});
    embedding.push_back(PointBetween(point.vertices[0], point.vertices[1], point.toward_second));
  }
  if (points.empty()) return nullptr;
  return std::make_unique<FieldCost>(
      std::make_shared<PointsOnFlame>(model_, embedding, shape_count_, expression_count_),
      std::move(points),
      rim,
      view);
}

}  // namespace cosplat::internal

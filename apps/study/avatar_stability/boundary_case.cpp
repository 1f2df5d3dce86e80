// Gaussians pushed repeatedly to one point on each rim of the mesh, neck and mouth.
#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/study/avatar_stability/cases.h"
#include "apps/study/avatar_stability/naive_walk.h"
#include "apps/study/avatar_stability/sketch.h"
#include "apps/study/avatar_stability/steps.h"
#include "avatar/surface/sample.h"
#include "avatar/surface/walk.h"

namespace cosplat {
namespace {

using math::Vec3;

constexpr size_t kSampled = 40000;
constexpr int kPushes = 60;
constexpr float kPush = 0.002f, kNear = 0.03f;  // metres
constexpr int kForEver = 1000;                  // rounds of one push that stand for an endless loop

// The foremost vertex of each boundary loop (FLAME's axes: the face looks along z).
std::vector<Vec3<float>> PlacesOnRims(const Surface& surface) {
  std::vector<Vec3<float>> places;
  for (const std::vector<int32_t>& loop : surface.topology().boundary_loops) {
    const int32_t foremost = *std::max_element(loop.begin(), loop.end(), [&](int a, int b) {
      return surface.canonical()[a].position.z < surface.canonical()[b].position.z;
    });
    places.push_back(surface.canonical()[foremost].position);
  }
  return places;
}

Vec3<float> Nearest(const std::vector<Vec3<float>>& places, const Vec3<float>& p) {
  return *std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
    return math::Length(a - p) < math::Length(b - p);
  });
}

Embedding StartsNear(const std::vector<Vec3<float>>& places,
                     const Surface& surface,
                     const CanonicalMesh& mesh) {
  Rng rng{11};
  Embedding starts;
  for (const SurfacePoint& p : SampleSurface(mesh, kSampled, rng)) {
    const Vec3<float> at = PlaceOf(surface, p);
    if (math::Length(Nearest(places, at) - at) > kNear) continue;
    starts.triangle.push_back(p.triangle);
    starts.barycentric.push_back(p.barycentric);
  }
  return starts;
}

// Largest number of points on one boundary face; infinite if a point is outside its face.
double Crowding(const Surface& surface, const Embedding& e) {
  std::vector<int> count(surface.faces().size());
  int max = 0;
  for (size_t i = 0; i < e.triangle.size(); ++i) {
    const auto [u, v] = e.barycentric[i];
    if (!(u >= 0 && v >= 0 && u + v <= 1 + 1e-6f)) return std::numeric_limits<double>::infinity();
    const auto& across = surface.topology().face_neighbors[e.triangle[i]];
    if (std::min({across[0], across[1], across[2]}) < 0)
      max = std::max(max, ++count[e.triangle[i]]);
  }
  return max;
}

// The neck's rim from the front: the front-facing part, from below the rim upwards.
Image8 ImageOfNeck(const Surface& surface, const Embedding& e, const SketchColor& ink) {
  constexpr float kSide = 0.05f;
  const std::vector<Vec3<float>> places = PlacesOnRims(surface);
  Vec3<float> low = places[0];
  for (const Vec3<float>& p : places)
    if (p.y < low.y) low = p;
  Sketch sketch(kStudyImage, kStudyImage);
  const float scale = kStudyImage / kSide;
  const auto x = [&](const Vec3<float>& p) { return (p.x - low.x) * scale + kStudyImage / 2; };
  const auto y = [&](const Vec3<float>& p) { return kStudyImage * 0.8f - (p.y - low.y) * scale; };
  const auto in_front = [&](int32_t f) { return CornerAt(surface, f, 0).z > low.z - kSide; };
  for (size_t f = 0; f < surface.faces().size(); ++f)
    for (int k = 0; k < 3 && in_front(int32_t(f)); ++k) {
      const Vec3<float> a = CornerAt(surface, int32_t(f), k);
      const Vec3<float> b = CornerAt(surface, int32_t(f), (k + 1) % 3);
      sketch.Line(x(a), y(a), x(b), y(b), kMeshLine);
    }
  for (size_t i = 0; i < e.triangle.size(); ++i) {
    const Vec3<float> p = PlaceOf(surface, {e.triangle[i], e.barycentric[i]});
    if (in_front(e.triangle[i])) sketch.Dot(x(p), y(p), 1.2f, ink);
  }
  return sketch.image();
}

}  // namespace

StabilityCase BoundaryCase(const StudyHead& head) {
  const Surface surface(head.avatar.mesh);
  const std::vector<Vec3<float>> places = PlacesOnRims(surface);
  Embedding naive = StartsNear(places, surface, head.avatar.mesh);
  Embedding ours = naive;
  Gaussians gaussians;
  gaussians.Resize(naive.triangle.size());
  const auto push = [&](const Embedding& e, size_t i) {
    const Vec3<float> at = PlaceOf(surface, {e.triangle[i], e.barycentric[i]});
    return StepOn(surface, e.triangle[i], math::Normalize(Nearest(places, at) - at) * kPush);
  };
  for (int n = 0; n < kPushes; ++n) {
    for (size_t i = 0; i < naive.triangle.size(); ++i) {
      const SurfacePoint at{naive.triangle[i], naive.barycentric[i]};
      const auto [du, dv] = push(naive, i);
      const SurfacePoint to = WalkNaively(surface, at, du, dv, kForEver).point;
      naive.triangle[i] = to.triangle;
      naive.barycentric[i] = to.barycentric;
      std::copy_n(push(ours, i).begin(), 2, gaussians.at(kPosition, i));
    }
    WalkAll(gaussians, ours, surface);
  }
  StabilityCase c;
  c.key = "walk_boundary";
  c.title = "A steady push to the edge of the mesh";
  c.what =
      "Every Gaussian within 3 cm of a place on the neck's rim, or the throat's, is pushed there "
      "60 times by 2 mm. They pile up on one triangle, or leave it where rounding is not caught.";
  c.quantity = "most Gaussians on one triangle at the rim, all weights within their triangle";
  c.bound = 64;
  c.naive = {"Stops on the edge, as released", Crowding(surface, naive), {}};
  c.ours = {"Slides along it; 64 for a triangle at the rim", Crowding(surface, ours), {}};
  c.naive.image = ImageOfNeck(surface, naive, kNaiveInk);
  c.ours.image = ImageOfNeck(surface, ours, kOursInk);
  return c;
}

}  // namespace cosplat

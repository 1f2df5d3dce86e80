// Distribution of the initial Gaussians, and whether they stay on their component of the head.
#include <algorithm>
#include <limits>

#include "apps/study/avatar_stability/cases.h"
#include "avatar/surface/sample.h"
#include "avatar/surface/walk.h"

namespace cosplat {
namespace {

constexpr size_t kComponentSamples = 3000;

// All components but the first (the head) are eyeballs.
bool IsOnAnEye(const Surface& surface, int32_t face) {
  return surface.topology().face_component[face] > 0;
}

double EyeShare(const Surface& surface, const std::vector<SurfacePoint>& points) {
  size_t on_eyes = 0;
  for (const SurfacePoint& p : points) on_eyes += IsOnAnEye(surface, p.triangle);
  return double(on_eyes) / double(points.size());
}

// Number of points that left their component after random steps across several triangles.
int CountStrays(const Surface& surface, std::vector<SurfacePoint> points) {
  constexpr int kWalks = 20;
  Rng rng{3};
  int strays = 0;
  for (SurfacePoint& p : points) {
    const int32_t component = surface.topology().face_component[p.triangle];
    for (int i = 0; i < kWalks; ++i) {
      const float du = 3 * rng.Normal(), dv = 3 * rng.Normal();
      p = Walk(surface, p, du, dv).point;
    }
    strays += surface.topology().face_component[p.triangle] != component;
  }
  return strays;
}

}  // namespace

StabilityCase EyeballShareCase(const StudyHead& head) {
  const CanonicalMesh& mesh = head.avatar.mesh;
  const Surface surface(mesh);
  double eye_area = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    if (IsOnAnEye(surface, int32_t(f))) eye_area += FaceArea(mesh, f);
  const double share = eye_area / SurfaceArea(mesh);
  StabilityCase c;
  c.key = "eyeball_share";
  c.title = "Eyeballs are finely divided";
  c.what =
      "3,000 first Gaussians are spread over the head, then take 20 random walks. Drawn by faces, "
      "the eyeballs, mostly hidden, get many times what their area needs, and the skin too few.";
  c.quantity = "Gaussians on the eyeballs for their area, none of them leaving by walking";
  c.unit = "times their share";
  c.bound = 1.1;
  c.naive.name = "Evenly over the faces, as released";
  c.ours.name = "Evenly over the area";
  for (StabilityForm* form : {&c.naive, &c.ours}) {
    Rng rng{6};
    const std::vector<SurfacePoint> points = form == &c.ours
                                                 ? SampleSurface(mesh, kComponentSamples, rng)
                                                 : SampleFaces(mesh, kComponentSamples, rng);
    form->value = EyeShare(surface, points) / share;
    if (form == &c.ours && CountStrays(surface, points) > 0)
      form->value = std::numeric_limits<double>::infinity();
    form->image =
        ImageOf(BoundBothWays(PaintedAvatar(head.head, points, rng, 0)).ours, StudyCamera());
  }
  return c;
}

}  // namespace cosplat

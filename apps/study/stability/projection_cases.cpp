// The stability cases of projection: a Gaussian's position, size and colour in the image.
#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/study/stability/cases.h"
#include "apps/study/stability/image.h"
#include "apps/study/stability/naive_render.h"
#include "apps/study/stability/test_scene.h"
#include "splat/math/vec.h"
#include "splat/render/rasterizer.h"

namespace cosplat {
namespace {

constexpr int kSide = 128;
constexpr float kGrazingScale = 1;  // standard deviation of the grazing splat, at depth 1

Image8 NaiveImage(const Gaussians& g, const Camera& camera, NaiveJacobian jacobian) {
  const auto footprints = NaiveFootprints(g, camera, jacobian);
  return ImageOf(DrawNaive(footprints, DepthOrder(footprints), camera.width, camera.height));
}
Image8 OurImage(const Gaussians& g, const Camera& camera) {
  return ImageOf(Draw(g, camera).ToImage());
}

// Radius of the first Gaussian in the product's renderer, px; 0 if it is not drawn.
float OurRadius(const Gaussians& g, const Camera& camera) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, {{0, 0, 0}, g.degree}, image, *tape);
  return tape->radii()[0];
}

Gaussians One(const Blob& blob) {
  Gaussians g;
  Append(blob, g);
  return g;
}

Blob Grazing(double degrees) {
  const float x = float(std::tan(degrees * M_PI / 180));
  return {{x, 0.2f, 1}, kGrazingScale, 0.95f, {1, 0.6f, 0.1f}};
}

// A camera with the principal point far left, so that the right image edge is at a large angle.
Camera OffCenterCamera() {
  Camera camera = StraightCamera(kSide);
  camera.cx = 0.1f * float(kSide);
  return camera;
}

// The product's footprint if the image extended that far: the same Gaussian with a wider image,
// which only moves the clamp.
float TrueRadius(const Gaussians& g, Camera camera) {
  camera.width *= 8;
  return OurRadius(g, camera);
}

// Scenes that each have some value at the end of its range.
std::vector<Gaussians> DegenerateScenes() {
  std::vector<Gaussians> scenes;
  const float scales[] = {-std::numeric_limits<float>::infinity(), -46, -2, 46};  // for 1e-20, 1e20
  for (const float norm : {0.0f, 1e-25f, 1.0f})
    for (const float first : scales)
      for (const float second : scales) {
        Gaussians g = RandomBlobs(30, 2.5f, 7);
        for (int k = 0; k < 4; ++k) g.at(kRotation, 0)[k] = 0.5f * norm;
        g.at(kScaleLog, 0)[0] = first;
        g.at(kScaleLog, 0)[1] = second;
        scenes.push_back(std::move(g));
      }
  return scenes;
}

double ShareNotFinite(const Image& image) {
  size_t count = 0;
  for (const float v : image.data) count += !std::isfinite(v);
  return double(count) / double(image.data.size());
}

}  // namespace

StabilityCase FrustumEdge() {
  const Camera camera = OffCenterCamera();
  StabilityCase s;
  s.key = "frustum_edge";
  s.title = "The projection's derivative far outside the image";
  s.what =
      "EWA splatting approximates perspective by its derivative at the centre, which grows without "
      "bound beside the camera: a Gaussian at 89 degrees, which nobody sees, smears over the image "
      "(three ordinary ones are in it). The principal point is at a tenth of the width.";
  s.quantity =
      "radius of a Gaussian at 89 degrees, one of 384 px straight ahead; 0: not on the image";
  s.unit = "px";
  s.chart = {"angle from the axis",
             "degrees",
             "radius",
             "px",
             false,
             true,
             {{"unclamped", {}}, {"clamped", {}}}};
  for (double degrees = 0; degrees < 89.8; degrees += degrees < 80 ? 4 : 0.5) {
    Gaussians g = One(Grazing(degrees));
    s.chart.curves[0].points.push_back({degrees, double(NaiveFootprintOf(g, 0, camera).Radius())});
    s.chart.curves[1].points.push_back({degrees, double(OurRadius(g, camera))});
  }
  Gaussians scene;
  Append({{0.15f, -0.15f, 1}, 0.05f, 0.95f, {0.9f, 0.2f, 0.2f}}, scene);
  Append({{0.4f, 0.2f, 1}, 0.08f, 0.95f, {0.2f, 0.7f, 0.3f}}, scene);
  Append({{0.65f, -0.2f, 1}, 0.06f, 0.95f, {0.2f, 0.4f, 0.9f}}, scene);
  Append(Grazing(89), scene);
  const Gaussians one = One(Grazing(89));
  s.naive = {"derivative at the centre (EWA splatting)",
             double(NaiveFootprintOf(one, 0, camera).Radius()),
             NaiveImage(scene, camera, NaiveJacobian::kUnclamped)};
  s.ours = {
      "clamped to 15 % beyond the image", double(OurRadius(one, camera)), OurImage(scene, camera)};
  s.bound = 570;  // 3 deviations of 128 px at the clamped slopes, times sqrt(1 + 1.05^2 + 0.2^2)
  return s;
}

StabilityCase OffCenterClamp() {
  Camera camera = OffCenterCamera();
  camera.fx = camera.fy = 48;
  Gaussians g = One({{2.1f, 0, 1}, 0.15f, 0.95f, {0.9f, 0.7f, 0.2f}});
  for (int i = 0; i < 3; ++i)  // a row of them towards the edge, to show how widths should grow
    Append({{0.1f + 0.6f * float(i), 0, 1}, 0.15f, 0.95f, {0.3f, 0.5f + 0.1f * float(i), 0.9f}}, g);
  StabilityCase s;
  s.key = "off_center_clamp";
  s.title = "A clamp about the image's middle";
  s.what =
      "3DGS clamps about the middle of the image, not the principal point: where they differ, "
      "Gaussians that are seen lose their width. The rightmost of the row, at 0.9 of the width.";
  s.quantity = "error of the width";
  s.unit = "percent";
  const double truth = TrueRadius(g, camera);
  const double naive = NaiveFootprintOf(g, 0, camera, NaiveJacobian::kAboutMiddle).Radius();
  s.naive = {"1.3 half-sizes about the middle (3DGS)",
             100 * std::abs(naive / truth - 1),
             NaiveImage(g, camera, NaiveJacobian::kAboutMiddle)};
  s.ours = {"about the principal point",
            100 * std::abs(OurRadius(g, camera) / truth - 1),
            OurImage(g, camera)};
  s.bound = 1e-4;
  return s;
}

StabilityCase DegenerateCovariance() {
  const Camera camera = StraightCamera(64);
  StabilityCase s;
  s.key = "degenerate_covariance";
  s.title = "No rotation, no extent, no end";
  s.what =
      "One Gaussian of thirty with a zero quaternion or scales of 0, 1e-20 or 1e20, in 48 "
      "combinations. A NaN is not below the least alpha, so it is drawn everywhere.";
  s.quantity = "pixels that are not a number, mean of all combinations";
  s.unit = "percent";
  double naive = 0, ours = 0;
  const std::vector<Gaussians> scenes = DegenerateScenes();
  for (const Gaussians& g : scenes) {
    const auto footprints = NaiveFootprints(g, camera);
    naive += ShareNotFinite(DrawNaive(footprints, DepthOrder(footprints), 64, 64));
    const DrawnBothWays drawn = DrawBothWays(g, camera);
    ours += CountNotFinite(drawn.gradients) > 0 ? 1 : ShareNotFinite(drawn.image.ToImage());
  }
  const Camera large = StraightCamera(kSide);
  const double percent = 100 / double(scenes.size());
  s.naive = {"q / |q|, inverse of any covariance",
             percent * naive,
             NaiveImage(scenes[10], large, NaiveJacobian::kUnclamped)};
  s.ours = {"not drawn, its gradients 0", percent * ours, OurImage(scenes[10], large)};
  s.bound = 0;
  return s;
}

StabilityCase CameraCenter() {
  StabilityCase s;
  s.key = "camera_center";
  s.title = "The direction to a Gaussian at the camera";
  s.what =
      "d / |d| of a Gaussian at, or almost at, the camera's centre: |d|^2 is 0 in a float below "
      "4e-23 and loses digits before.";
  s.quantity = "offsets of 61, from 0 to 1e-30 ... 1, whose direction is not of length 0 or 1";
  const auto is_wrong = [](const math::Vec3<float>& u) {
    const float length = std::sqrt(math::Dot(u, u));
    return !(length == 0 || std::abs(length - 1) < 1e-5f);
  };
  for (int i = 0; i <= 60; ++i) {
    const float size = i == 0 ? 0 : float(std::pow(10.0, 0.5 * (i - 60)));
    const math::Vec3<float> d{0.6f * size, 0.48f * size, -0.64f * size};
    const float norm = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    s.naive.value += is_wrong({d.x / norm, d.y / norm, d.z / norm});
    s.ours.value += is_wrong(math::Normalize(d));
  }
  s.naive.name = "d / |d|";
  s.ours.name = "0 below 1e-15";
  s.bound = 0;
  return s;
}

}  // namespace cosplat

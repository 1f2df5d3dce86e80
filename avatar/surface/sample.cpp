#include "avatar/surface/sample.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "avatar/surface/kernels/reembed.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// Source: Osada et al. 2002, section 4.2.
std::array<float, 2> UniformOnTriangle(Rng& rng) {
  const double s = std::sqrt(double(rng.Uniform())), t = rng.Uniform();
  const math::Weights b = math::KeepInsideTriangle({{1 - s, s * (1 - t), s * t}});
  return {float(b[0]), float(b[1])};
}

}  // namespace

std::vector<SurfacePoint> SampleSurface(const CanonicalMesh& mesh, size_t n, Rng& rng) {
  std::vector<double> area_up_to;
  double total = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    total += FaceArea(mesh, f);
    area_up_to.push_back(total);
  }
  if (!(total > 0) || !std::isfinite(total))
    throw Error("canonical mesh", "area", "is " + std::to_string(total));
  std::vector<SurfacePoint> points(n);
  for (size_t i = 0; i < n; ++i) {
    const double target = (double(i) + rng.Uniform()) / double(n) * total;
    const auto face = std::upper_bound(area_up_to.begin(), area_up_to.end(), target);
    points[i].triangle =
        int32_t(std::min<ptrdiff_t>(face - area_up_to.begin(), ptrdiff_t(mesh.faces.size()) - 1));
    points[i].barycentric = UniformOnTriangle(rng);
  }
  return points;
}

std::vector<SurfacePoint> SampleFaces(const CanonicalMesh& mesh, size_t n, Rng& rng) {
  if (mesh.faces.empty()) throw Error("canonical mesh", "faces", "there are none");
  std::vector<SurfacePoint> points(n);
  for (SurfacePoint& point : points) {
    point.triangle = int32_t(rng.Below(mesh.faces.size()));
    point.barycentric = UniformOnTriangle(rng);
  }
  return points;
}

EmbeddedPoint Reembed(const Surface& surface, const std::array<float, 3>& point, int32_t start) {
  if (size_t(start) >= surface.faces().size())
    throw Error("embedding",
                "triangle",
                std::to_string(start) + " of " + std::to_string(surface.faces().size()));
  const math::Vec3<double> x{point[0], point[1], point[2]};
  if (!std::isfinite(x.x + x.y + x.z)) throw Error("embedding", "point", "is not finite");
  math::FaceSearch search;
  const math::Reembedded e = math::ReembedNear(surface.CanonicalArrays(), start, x, search);
  return {
      {e.face, {float(e.barycentric[0]), float(e.barycentric[1])}}, float(e.d), float(e.residual)};
}

}  // namespace cosplat

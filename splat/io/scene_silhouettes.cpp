#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "splat/base/text.h"
#include "splat/io/scene_fit.h"

namespace cosplat {
namespace {

using Point = std::array<double, 3>;

// None if rows depend on each other.
std::optional<Point> Solve(std::array<std::array<double, 4>, 3> a) {
  for (int i = 0; i < 3; ++i) {
    int pivot = i;
    for (int r = i + 1; r < 3; ++r)
      if (std::abs(a[r][i]) > std::abs(a[pivot][i])) pivot = r;
    std::swap(a[i], a[pivot]);
    if (std::abs(a[i][i]) < 1e-9) return {};
    for (int r = 0; r < 3; ++r) {
      if (r == i) continue;
      const double f = a[r][i] / a[i][i];
      for (int c = i; c < 4; ++c) a[r][c] -= f * a[i][c];
    }
  }
  return Point{a[0][3] / a[0][0], a[1][3] / a[1][1], a[2][3] / a[2][2]};
}

// The point nearest to the rays through the middles of all silhouettes: of optical axes, which may
// be parallel, it can be anywhere.
std::optional<Point> CommonMiddleOf(const std::vector<LookedAt>& looked,
                                    const std::vector<Camera>& cameras) {
  std::array<std::array<double, 4>, 3> a{};
  for (size_t v = 0; v < looked.size(); ++v) {
    const Camera& camera = cameras[v];
    const Image8& image = looked[v].image;
    double sum[3] = {0, 0, 0};  // of the silhouette's pixels: x, y, their count
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (image.at(x, y, 3) > 127) sum[0] += x + 0.5, sum[1] += y + 0.5, ++sum[2];
    if (sum[2] == 0) continue;
    const double in_camera[3] = {
        (sum[0] / sum[2] - camera.cx) / camera.fx, (sum[1] / sum[2] - camera.cy) / camera.fy, 1};
    const double length = std::hypot(in_camera[0], in_camera[1], 1.0);
    Point ray{};
    for (size_t k = 0; k < 3; ++k)
      for (size_t r = 0; r < 3; ++r)
        ray[k] += double(camera.rotation[3 * r + k]) * in_camera[r] / length;
    const std::array<float, 3> center = camera.Center();
    for (size_t r = 0; r < 3; ++r)
      for (size_t k = 0; k < 3; ++k) {
        const double m = (r == k ? 1 : 0) - ray[r] * ray[k];
        a[r][k] += m;
        a[r][3] += m * double(center[k]);
      }
  }
  return Solve(a);
}

// A view's silhouette in cells, of which each is as large as the distance of neighbouring points of
// the lattice where the camera sees it nearest.
struct CoarseSilhouette {
  int width = 0, height = 0;
  std::vector<uint8_t> has;   // [height, width] some of its pixels
  std::vector<uint8_t> near;  // likewise, or a cell beside has

  size_t At(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

// The cells beside the one at (x, y), and it.
template <class Action>
void ForEachBeside(const CoarseSilhouette& cells, int x, int y, const Action& action) {
  for (int v = std::max(0, y - 1); v <= std::min(cells.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(cells.width - 1, x + 1); ++u)
      action(cells.At(u, v));
}

CoarseSilhouette Coarse(const Image8& image, float cell) {
  CoarseSilhouette coarse;
  coarse.width = std::max(1, int(float(image.width) / cell));
  coarse.height = std::max(1, int(float(image.height) / cell));
  coarse.has.resize(size_t(coarse.width) * size_t(coarse.height));
  coarse.near = coarse.has;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (image.at(x, y, 3) > 127) {
        coarse.has[coarse.At(x * coarse.width / image.width, y * coarse.height / image.height)] = 1;
      }
  for (int v = 0; v < coarse.height; ++v)
    for (int u = 0; u < coarse.width; ++u)
      if (coarse.has[coarse.At(u, v)])
        ForEachBeside(coarse, u, v, [&](size_t i) { coarse.near[i] = 1; });
  return coarse;
}

double DistanceOf(const Camera& camera, const Point& middle) {
  const std::array<float, 3> c = camera.Center();
  return std::hypot(c[0] - middle[0], c[1] - middle[1], c[2] - middle[2]);
}

// Of the sphere about `middle` that holds what the silhouettes show; infinite if a view shows what
// is not before it.
double RadiusOf(const std::vector<LookedAt>& looked,
                const std::vector<Camera>& cameras,
                const Point& middle) {
  double radius = 0;
  for (size_t v = 0; v < looked.size(); ++v) {
    const Camera& c = cameras[v];
    double to[3];  // the middle, from the camera
    for (size_t r = 0; r < 3; ++r) {
      to[r] = c.translation[r];
      for (size_t k = 0; k < 3; ++k) to[r] += double(c.rotation[3 * r + k]) * middle[k];
    }
    const double distance = std::hypot(to[0], to[1], to[2]);
    const Image8& image = looked[v].image;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (image.at(x, y, 3) <= 127) continue;
        const double ray[2] = {(x + 0.5 - c.cx) / c.fx, (y + 0.5 - c.cy) / c.fy};
        const double along =
            (ray[0] * to[0] + ray[1] * to[1] + to[2]) / std::hypot(ray[0], ray[1], 1.0);
        if (along <= 0) return HUGE_VAL;
        radius = std::max(radius, std::sqrt(std::max(0.0, distance * distance - along * along)));
      }
  }
  return radius;
}

// How much of the silhouettes the object's hull covers, the points of a lattice about their
// middle that lie in the silhouettes of all that see them, but for a share that may lack
// them: all of it, if silhouettes are of these cameras, however thin the object is. None where
// cameras are among what they look at.
std::optional<double> CoveredByHull(const std::vector<LookedAt>& looked,
                                    const Reading& how,
                                    double may_lack) {
  constexpr int kLattice = 64;
  constexpr int kAtLeast = 3;  // views see a point of the hull
  constexpr double kLargest = 0.8;
  std::vector<Camera> cameras;
  for (const LookedAt& one : looked) cameras.push_back(ReadAs(one.camera, how));
  const std::optional<Point> found = CommonMiddleOf(looked, cameras);
  if (!found) return {};
  const Point& middle = *found;
  const double half = RadiusOf(looked, cameras, middle), spacing = 2 * half / (kLattice - 1);
  for (const Camera& camera : cameras)
    if (!(half < kLargest * DistanceOf(camera, middle))) return {};
  struct Seen {
    CoarseSilhouette silhouette;
    std::vector<uint8_t> looked_at, covered;  // cells where the lattice is, its hull
  };
  std::vector<Seen> views(looked.size());
  tbb::parallel_for(size_t(0), looked.size(), [&](size_t v) {
    const double cell = std::abs(cameras[v].fx) * spacing / (DistanceOf(cameras[v], middle) - half);
    views[v].silhouette = Coarse(looked[v].image, std::max(1.f, float(cell)));
    views[v].looked_at.resize(views[v].silhouette.has.size());
    views[v].covered = views[v].looked_at;
  });
  const auto cell_of = [&](size_t v, const float* point) -> std::optional<std::array<int, 2>> {
    const auto place = PlaceOf(cameras[v], point);
    if (!place) return {};
    const CoarseSilhouette& cells = views[v].silhouette;
    return std::array{CellOf((*place)[0], cells.width), CellOf((*place)[1], cells.height)};
  };
  for (int i = 0; i < kLattice * kLattice * kLattice; ++i) {
    float point[3];
    const int at[3] = {i % kLattice, i / kLattice % kLattice, i / kLattice / kLattice};
    for (size_t k = 0; k < 3; ++k) point[k] = float(middle[k] + spacing * at[k] - half);
    int seen = 0, lack = 0;
    for (size_t v = 0; v < looked.size(); ++v)
      if (const auto cell = cell_of(v, point)) {
        const size_t index = views[v].silhouette.At((*cell)[0], (*cell)[1]);
        views[v].looked_at[index] = 1;
        lack += !views[v].silhouette.near[index];
        ++seen;
      }
    if (lack > may_lack * seen || seen < kAtLeast) continue;
    for (size_t v = 0; v < looked.size(); ++v)
      if (const auto cell = cell_of(v, point))
        ForEachBeside(views[v].silhouette, (*cell)[0], (*cell)[1], [&](size_t index) {
          views[v].covered[index] = 1;
        });
  }
  double sum = 0;
  size_t count = 0;
  for (const Seen& view : views) {
    size_t has = 0, covered = 0;
    for (size_t i = 0; i < view.covered.size(); ++i)
      if (view.silhouette.has[i] && view.looked_at[i]) ++has, covered += view.covered[i];
    if (has > 0) sum += double(covered) / double(has), ++count;
  }
  if (count == 0) return {};
  return sum / double(count);
}

}  // namespace

// Renderings have 1.00 as they are, 0.74 and 0.87 with images of other views where a tenth may lack
// a point, 0.89 and 0.96 turned upside down where none may. What this cannot tell: another focal
// length or unit, which scales the hull, and a neighbour's image.
void CheckSilhouettes(const std::vector<LookedAt>& looked, std::vector<Finding>& findings) {
  constexpr double kBetter = 0.03, kCovered = 0.9;
  constexpr double kMattesFail = 0.1;  // of cut out photographs: a part is missing in a view or two
  if (looked.size() < 6) return;
  for (const LookedAt& one : looked)
    if (one.image.channels != 4 || GreatestAlpha(one.image) < 128) return;
  const std::optional<double> given = CoveredByHull(looked, {}, 0);
  if (given && *given > 1 - kBetter) return;
  const Reading* better = nullptr;
  double max = std::max(1 - kBetter, given.value_or(0) + kBetter);
  for (const Reading& reading : kReadings) {
    if (reading.focal != 1) continue;  // which scales the hull
    const double covered = CoveredByHull(looked, reading, 0).value_or(0);
    if (covered > max) max = covered, better = &reading;
  }
  const auto say = [&](double share, const std::string& then) {
    findings.push_back({true,
                        "what lies in the silhouettes of all views covers " +
                            Format("{:.0f} %", 100 * share) + " of them" + then});
  };
  if (better != nullptr)
    return say(given.value_or(0),
               Format(", and {:.0f} % with ", 100 * max) + better->what +
                   ": look at the cameras and images");
  const std::optional<double> nearly = CoveredByHull(looked, {}, kMattesFail);
  if (nearly && *nearly < kCovered)
    say(*nearly,
        ": the images are not these cameras' (exchanged or renamed), or poses or focal length are "
        "wrong");
}

}  // namespace cosplat

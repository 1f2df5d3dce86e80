// How the size of a Gaussian follows that of its triangle, and in which unit.
#include <algorithm>
#include <cmath>

#include "apps/study/avatar_stability/cases.h"
#include "splat/base/median.h"
#include "splat/train/loss/loss.h"

namespace cosplat {
namespace {

constexpr float kReleasedUnits = 4;  // SplattingAvatar enlarges FLAME's mesh by this factor

std::vector<float> Times(std::vector<float> vertices, float factor) {
  for (float& x : vertices) x *= factor;
  return vertices;
}

Camera Farther(Camera camera, float factor) {
  for (float& t : camera.translation) t *= factor;
  return camera;
}

// The same avatar on a mesh `factor` times as large.
AvatarModel Enlarged(AvatarModel avatar, float factor) {
  avatar.mesh.vertices = Times(avatar.mesh.vertices, factor);
  for (float& s : avatar.gaussians.values[kScaleLog]) s += std::log(factor);
  for (size_t i = 0; i < avatar.size(); ++i) avatar.gaussians.at(kPosition, i)[2] *= factor;
  return avatar;
}

double MedianScale(const PosedGaussians& posed) {
  std::vector<float> scales(posed.size());
  for (size_t i = 0; i < scales.size(); ++i) scales[i] = LargestScale(posed, i);
  return Median(scales);
}

// The left half of one image next to the right half of another.
Image8 LeftOfOther(const Image8& left, Image8 right) {
  for (int y = 0; y < right.height; ++y)
    std::copy_n(&left.at(0, y, 0), right.width / 2 * right.channels, &right.at(0, y, 0));
  return right;
}

}  // namespace

StabilityCase InverseScaleCase(const StudyHead& head) {
  StabilityCase c;
  c.key = "inverse_scale";
  c.title = "Size of a Gaussian against its triangle's area";
  c.what =
      "The whole head shrinks and grows. Scaling the logarithm in place of the size turns it "
      "round: half the area makes Gaussians larger, twice the area makes them vanish.";
  c.quantity = "how far four times the area is from twice the size";
  c.unit = "octaves";
  c.bound = 0.01;
  c.naive.name = "exp(log s A / A0), as released";
  c.ours.name = "s sqrt(A / A0)";
  c.chart = {"area, of the area at rest", "", "median size, of that at rest", "", true, true, {}};
  BoundBothWays bound(head.avatar);
  const double rest = MedianScale(bound.ours.posed);
  for (BoundBothWays::Way* way : {&bound.naive, &bound.ours}) {
    const bool is_ours = way == &bound.ours;
    StabilityForm& form = is_ours ? c.ours : c.naive;
    StabilityCurve curve{form.name, {}};
    for (int half_octaves = -4; half_octaves <= 4; ++half_octaves) {
      const double area = std::exp2(0.5 * half_octaves);
      bound.Pose(Times(head.avatar.mesh.vertices, float(std::sqrt(area))));
      curve.points.push_back({area, MedianScale(way->posed) / rest});
    }
    for (size_t i = 4; i < curve.points.size(); ++i) {
      const double octaves = std::log2(curve.points[i][1] / curve.points[i - 4][1]);
      form.value = std::max(form.value, std::abs(octaves - 1));
    }
    c.chart.curves.push_back(curve);
    const float half = std::sqrt(0.5f);
    bound.Pose(Times(head.avatar.mesh.vertices, half));
    form.image = ImageOf(*way, Farther(StudyCamera(), half));
  }
  return c;
}

StabilityCase UnitsCase(const StudyHead& head) {
  StabilityCase c;
  c.key = "units";
  c.title = "The same head in metres and in quarters of a metre";
  c.what =
      "Mesh, Gaussians and camera four times as large must give the same image. A constant that "
      "is added to areas has a unit, and so has a logarithm that is scaled. Left half small, right "
      "large.";
  c.quantity = "likeness of the two images of a grimace";
  c.unit = "dB";
  c.bound = 60;
  c.at_least = true;
  c.naive.name = "Areas plus 1e-4 of whatever unit";
  c.ours.name = "Ratios of areas";
  const std::vector<float> vertices = head.Vertices(Grimace());
  const AvatarModel large_avatar = Enlarged(head.avatar, kReleasedUnits);
  BoundBothWays small(head.avatar, 1), large(large_avatar, 1);
  small.Pose(vertices);
  large.Pose(Times(vertices, kReleasedUnits));
  const Camera near = StudyCamera(), far = Farther(near, kReleasedUnits);
  const auto likeness = [&](const BoundBothWays::Way& a, const BoundBothWays::Way& b) {
    return Psnr(DrawOver(a, near, {1, 1, 1}).color, DrawOver(b, far, {1, 1, 1}).color);
  };
  c.naive.value = likeness(small.naive, large.naive);
  c.ours.value = likeness(small.ours, large.ours);
  c.naive.image = LeftOfOther(ImageOf(small.naive, near), ImageOf(large.naive, far));
  c.ours.image = LeftOfOther(ImageOf(small.ours, near), ImageOf(large.ours, far));
  return c;
}

}  // namespace cosplat

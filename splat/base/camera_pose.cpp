#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/base/text.h"
#include "splat/math/vec.h"

namespace cosplat {
namespace {

constexpr double kOrthonormalTolerance = 1e-3;

using Row = math::Vec3<double>;

}  // namespace

PoseProblem SetPose(const std::array<double, 9>& rotation,
                    const std::array<double, 3>& translation,
                    Camera& camera,
                    std::array<double, 3>* center) {
  for (double x : rotation)
    if (!std::isfinite(x)) return "pose has a rotation that is not finite";
  for (double x : translation)
    if (!std::isfinite(float(x))) return "pose has a translation that is not finite";
  std::array<Row, 3> r;
  for (int i = 0; i < 3; ++i) r[i] = math::ToVec3(&rotation[3 * i]);
  for (int i = 0; i < 3; ++i)
    for (int k = i; k < 3; ++k) {
      const double dot = Dot(r[i], r[k]);
      if (std::abs(dot - (i == k)) > kOrthonormalTolerance)
        return "pose has a rotation that is not orthonormal: the dot product of rows " +
               std::to_string(i) + " and " + std::to_string(k) + " is " + Format("{:.4g}", dot);
    }
  const double determinant = Dot(Cross(r[0], r[1]), r[2]);
  if (determinant < 0)
    return "pose has a reflection instead of a rotation: determinant " +
           Format("{:.4g}", determinant);
  // Gram-Schmidt; the third row follows from the others.
  const double n0 = std::sqrt(Dot(r[0], r[0]));
  for (int k = 0; k < 3; ++k) r[0][k] /= n0;
  const double along = Dot(r[0], r[1]);
  r[1] -= along * r[0];
  const double n1 = std::sqrt(Dot(r[1], r[1]));
  for (int k = 0; k < 3; ++k) r[1][k] /= n1;
  r[2] = Cross(r[0], r[1]);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) camera.rotation[3 * i + k] = float(r[i][k]);
    camera.translation[i] = float(translation[i]);
    if (!center) continue;
    (*center)[i] = 0;
    for (int k = 0; k < 3; ++k) (*center)[i] -= r[k][i] * translation[k];
  }
  return "";
}

PoseProblem SetPoseFromWorldFromCam(const std::array<double, 12>& matrix,
                                    Camera& camera,
                                    std::array<double, 3>* center) {
  // The inverse of [R c] is [R^T, -R^T c].
  std::array<double, 9> rotation;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) rotation[3 * i + k] = matrix[4 * k + i];
  std::array<double, 3> translation{};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) translation[i] -= rotation[3 * i + k] * matrix[4 * k + 3];
  if (center) *center = {matrix[3], matrix[7], matrix[11]};
  return SetPose(rotation, translation, camera);
}

PoseProblem SetPoseFromOpenGlWorldFromCam(const std::array<double, 12>& matrix,
                                          Camera& camera,
                                          std::array<double, 3>* center) {
  // OpenCV's axes are OpenGL's rotated by 180 degrees about x: columns 1 and 2 change sign.
  std::array<double, 12> opencv = matrix;
  for (int r = 0; r < 3; ++r)
    for (int c = 1; c < 3; ++c) opencv[4 * r + c] = -matrix[4 * r + c];
  return SetPoseFromWorldFromCam(opencv, camera, center);
}

PoseProblem RowsOfPose(const std::vector<double>& numbers,
                       std::array<double, 12>& matrix,
                       bool& transposed) {
  transposed = false;
  if (numbers.size() != 16 && numbers.size() != 12)
    return "pose has " + std::to_string(numbers.size()) + " numbers, expected 16 or 12";
  std::copy_n(numbers.begin(), 12, matrix.begin());
  if (numbers.size() == 12) return "";
  constexpr double kRounding = 1e-4;
  // Step 1: the last row, step 4: the last column.
  const auto is_last = [&](size_t first, size_t step) {
    for (size_t i = 0; i < 4; ++i)
      if (!(std::abs(numbers[first + step * i] - (i == 3 ? 1 : 0)) <= kRounding)) return false;
    return true;
  };
  if (is_last(12, 1)) return "";
  if (!is_last(3, 4))
    return Format("pose has the last row {:.4g} {:.4g} {:.4g} {:.4g}, expected 0 0 0 1",
                  numbers[12],
                  numbers[13],
                  numbers[14],
                  numbers[15]);
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) matrix[4 * r + c] = numbers[4 * c + r];
  transposed = true;
  return "";
}

std::string LensProblem(const Camera& lens) {
  constexpr float kCorner = 1;         // px
  constexpr float kMinFocal = 0.088f;  // of the width: 160 degrees
  constexpr float kMaxStretch = 1.9f;  // 16:9 squeezed into a square has 1.78
  if (std::abs(lens.cx) <= kCorner && std::abs(lens.cy) <= kCorner)
    return Format(
        "the principal point is ({:g}, {:g}) px, in the image's corner", lens.cx, lens.cy);
  if (lens.fx < kMinFocal * float(lens.width) || lens.fy < kMinFocal * float(lens.height))
    return Format("the focal length {:g} px would see {:.0f} degrees of an image of {} px",
                  lens.fx,
                  360 / std::numbers::pi * std::atan(lens.width / (2.0 * lens.fx)),
                  SizeText(lens.width, lens.height));
  if (lens.fx > kMaxStretch * lens.fy || lens.fy > kMaxStretch * lens.fx)
    return Format("the focal lengths are {:g} and {:g} px: pixels are not so far from square",
                  lens.fx,
                  lens.fy);
  return "";
}

}  // namespace cosplat

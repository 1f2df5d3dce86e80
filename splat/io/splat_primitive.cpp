#include "splat/io/splat_primitive.h"

#include <algorithm>
#include <cmath>

#include "splat/base/error.h"
#include "splat/math/quat.h"
#include "splat/math/scalar.h"

namespace cosplat {
namespace {

const std::string kPrefix = std::string(kSplatExtension) + ":";

// One attribute's array, [count, width].
struct Column {
  std::string name;
  int width;
  std::vector<float> values;
};

Column MakeColumn(const std::string& name, int width, size_t count) {
  return {name, width, std::vector<float>(width * count)};
}

int Add(GlbDocument& document, const Column& column, GlbUse use) {
  for (size_t i = 0; i < column.values.size(); ++i)
    if (!std::isfinite(column.values[i]))
      throw Error(document.path,
                  "Gaussian " + std::to_string(i / column.width) + ", " + column.name,
                  "is not finite (" + std::to_string(column.values[i]) + ")");
  return AddFloats(document, column.values, column.width, use);
}

// Exponentials are computed in double, so that their rounding to float, and hence the file's bytes,
// do not depend on the machine's math library.
void FillGeometry(const Gaussians& g, size_t i, Column& rotation, Column& scale, Column& opacity) {
  const float* r = g.at(kRotation, i);
  math::Quat<float> q{r[0], r[1], r[2], r[3]};
  if (std::isfinite(math::Dot(q, q))) q = math::Normalize(q);
  const std::array<float, 4> xyzw{q.x, q.y, q.z, q.w};
  std::copy(xyzw.begin(), xyzw.end(), &rotation.values[4 * i]);
  for (int k = 0; k < 3; ++k)
    scale.values[3 * i + k] = float(std::exp(double(g.at(kScaleLog, i)[k])));
  opacity.values[i] = float(math::Sigmoid(double(*g.at(kOpacityLogit, i))));
}

}  // namespace

std::string SplatCoefficientName(int coefficient) {
  int degree = 0;
  while (CoefficientCount(degree) <= coefficient) ++degree;
  return kPrefix + "SH_DEGREE_" + std::to_string(degree) + "_COEF_" +
         std::to_string(coefficient - degree * degree);
}

GlbPrimitive AddSplats(GlbDocument& document, const Gaussians& gaussians, bool truncate_degree) {
  const size_t n = gaussians.size();
  if (n == 0) throw Error(document.path, "there are no Gaussians to write");
  if (gaussians.degree > kMaxSplatFileDegree && !truncate_degree)
    throw Error(
        document.path,
        "degree",
        "is " + std::to_string(gaussians.degree) +
            ", other programs read degrees up to 3: request truncation to drop higher bands");
  GlbPrimitive primitive;
  primitive.mode = kGlbPoints;
  const auto add = [&](const Column& column, GlbUse use = GlbUse::kAttribute) {
    primitive.attributes[column.name] = Add(document, column, use);
  };
  Column position = MakeColumn("POSITION", 3, n);
  std::copy_n(gaussians.at(kPosition, 0), 3 * n, position.values.begin());
  add(position, GlbUse::kPosition);
  Column rotation = MakeColumn(kPrefix + "ROTATION", 4, n);
  Column scale = MakeColumn(kPrefix + "SCALE", 3, n);
  Column opacity = MakeColumn(kPrefix + "OPACITY", 1, n);
  for (size_t i = 0; i < n; ++i) FillGeometry(gaussians, i, rotation, scale, opacity);
  add(rotation);
  add(scale);
  add(opacity);
  Gaussians sh = gaussians;
  ConvertBasis(sh, Basis::kSh);
  const int coefficients = CoefficientCount(std::min(sh.degree, kMaxSplatFileDegree));
  for (int k = 0; k < coefficients; ++k) {
    Column color = MakeColumn(SplatCoefficientName(k), 3, n);
    for (size_t i = 0; i < n; ++i)
      std::copy_n(k == 0 ? sh.at(kColorDc, i) : sh.at(kColorRest, i) + 3 * (k - 1),
                  3,
                  &color.values[3 * i]);
    add(color);
  }
  primitive.extensions[kSplatExtension] = {{"kernel", "ellipse"},
                                           {"colorSpace", "srgb_rec709_display"},
                                           {"projection", "perspective"},
                                           {"sortingMethod", "cameraDistance"}};
  return primitive;
}

}  // namespace cosplat

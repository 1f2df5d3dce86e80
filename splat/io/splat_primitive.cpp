#include "splat/io/splat_primitive.h"

#include <algorithm>
#include <cmath>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/io/packed_values.h"
#include "splat/io/splat_values.h"
#include "splat/math/quat.h"
#include "splat/math/scalar.h"

namespace cosplat {
namespace {

constexpr const char* kAntialiased = "antialiased";  // in the extension's extras
const std::string kPrefix = std::string(kSplatExtension) + ":";

bool HasSplats(const GlbPrimitive& primitive) {
  return primitive.extensions.is_object() && primitive.extensions.contains(kSplatExtension);
}

// Without a filter's variance: ours, which wrote none at first.
void ReadAntialiased(const std::string& path, const GlbPrimitive& primitive, Gaussians& g) {
  const Json& extension = primitive.extensions.at(kSplatExtension);
  if (!extension.contains("extras") || !extension["extras"].contains(kAntialiased)) return;
  const JsonField extras(path, extension["extras"]);
  if (extras[kAntialiased].raw() == true)
    SetAntialiased(path, extras.NumberOr(kLowPassField, kAntialiasedBlurVariance), g);
}

// An attribute's floats, [count, width]; any count if `count` is 0.
std::vector<float> ReadAttribute(const GlbDocument& document,
                                 const GlbPrimitive& primitive,
                                 const std::string& name,
                                 int width,
                                 size_t count) {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end())
    throw Error(document.path, name, "is missing from the splats");
  std::vector<float> values = ReadValues<float>(document, found->second, width, name);
  if (count != 0 && values.size() != size_t(width) * count)
    throw Error(document.path,
                name,
                Format("has {} elements, POSITION has {}", values.size() / size_t(width), count));
  return values;
}

// What a user should know of how the file is read.
void Note(const GlbDocument& document, bool logarithms, std::vector<std::string>& notes) {
  if (logarithms)
    notes.push_back(
        "has negative scales: they are read as logarithms, as SplatTransform wrote them before its "
        "version of June 2026");
  if (document.has_transforms)
    notes.push_back("has nodes that are moved, turned or scaled, which is not applied");
}

void CheckOpacities(const GlbDocument& document, const std::vector<float>& values) {
  for (size_t i = 0; i < values.size(); ++i)
    if (!(values[i] >= 0 && values[i] <= 1))
      throw Error(document.path,
                  kPrefix + "OPACITY",
                  Format("number {} is {}, expected 0 to 1", i, values[i]));
}

}  // namespace

std::string SplatCoefficientName(int coefficient) {
  int degree = 0;
  while (CoefficientCount(degree) <= coefficient) ++degree;
  return Format("{}SH_DEGREE_{}_COEF_{}", kPrefix, degree, coefficient - degree * degree);
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
  // fill(i, out): the floats of Gaussian i.
  const auto add = [&](const std::string& name, int width, GlbUse use, const auto& fill) {
    std::vector<float> values(width * n);
    for (size_t i = 0; i < n; ++i) fill(i, &values[width * i]);
    for (size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]))
        throw Error(document.path,
                    "Gaussian " + std::to_string(i / width) + ", " + name,
                    "is not finite (" + std::to_string(values[i]) + ")");
    primitive.attributes[name] = AddValues<float>(document, values, width, use);
  };
  add("POSITION", 3, GlbUse::kPosition, [&](size_t i, float* xyz) {
    std::copy_n(gaussians.at(kPosition, i), 3, xyz);
  });
  Gaussians sh = gaussians;
  ConvertBasis(sh, Basis::kSh);
  HideWithoutRotation(sh);
  add(kPrefix + "ROTATION", 4, GlbUse::kAttribute, [&](size_t i, float* xyzw) {
    const float* r = sh.at(kRotation, i);
    math::Quat<float> q{r[0], r[1], r[2], r[3]};
    if (std::isfinite(math::Dot(q, q))) q = math::Normalize(q);
    std::copy_n(std::array{q.x, q.y, q.z, q.w}.begin(), 4, xyzw);
  });
  // Exponentials are computed in double, so that their rounding to float, and hence the file's
  // bytes, do not depend on the machine's math library.
  add(kPrefix + "SCALE", 3, GlbUse::kAttribute, [&](size_t i, float* scale) {
    for (int k = 0; k < 3; ++k) scale[k] = float(std::exp(double(sh.at(kScaleLog, i)[k])));
  });
  add(kPrefix + "OPACITY", 1, GlbUse::kAttribute, [&](size_t i, float* opacity) {
    *opacity = float(math::Sigmoid(double(*sh.at(kOpacityLogit, i))));
  });
  const int coefficients = CoefficientCount(std::min(sh.degree, kMaxSplatFileDegree));
  for (int k = 0; k < coefficients; ++k)
    add(SplatCoefficientName(k), 3, GlbUse::kAttribute, [&](size_t i, float* rgb) {
      std::copy_n(k == 0 ? sh.at(kColorDc, i) : sh.at(kColorRest, i) + 3 * (k - 1), 3, rgb);
    });
  primitive.extensions[kSplatExtension] = {{"kernel", "ellipse"},
                                           {"colorSpace", "srgb_rec709_display"},
                                           {"projection", "perspective"},
                                           {"sortingMethod", "cameraDistance"}};
  // Not part of the extension, which has no word for it: other programs pass over it.
  if (gaussians.antialiased)
    primitive.extensions[kSplatExtension]["extras"] = {{kAntialiased, true},
                                                       {kLowPassField, LowPassNumber(gaussians)}};
  return primitive;
}

const GlbPrimitive& FindSplats(const GlbDocument& document) {
  const GlbPrimitive* found = nullptr;
  for (const GlbMesh& mesh : document.meshes)
    for (const GlbPrimitive& primitive : mesh.primitives) {
      if (!HasSplats(primitive)) continue;
      if (found) throw Error(document.path, kSplatExtension, "is on more than one primitive");
      found = &primitive;
    }
  if (!found)
    throw Error(document.path,
                kSplatExtension,
                "is not used by any primitive: the file contains no splats");
  return *found;
}

Gaussians ReadSplatPrimitive(const GlbDocument& document,
                             const GlbPrimitive& primitive,
                             std::vector<std::string>* notes) {
  const std::vector<float> position = ReadAttribute(document, primitive, "POSITION", 3, 0);
  const size_t n = position.size() / 3;
  const std::vector<float> rotation =
      ReadAttribute(document, primitive, kPrefix + "ROTATION", 4, n);
  const std::vector<float> scale = ReadAttribute(document, primitive, kPrefix + "SCALE", 3, n);
  const std::vector<float> opacity = ReadAttribute(document, primitive, kPrefix + "OPACITY", 1, n);
  CheckOpacities(document, opacity);
  const bool logarithms = *std::min_element(scale.begin(), scale.end()) < 0;
  if (notes) Note(document, logarithms, *notes);
  Gaussians g;
  g.basis = Basis::kSh;
  while (g.degree < kMaxSplatFileDegree &&
         primitive.attributes.contains(SplatCoefficientName(CoefficientCount(g.degree))))
    ++g.degree;
  ReadAntialiased(document.path, primitive, g);
  g.Resize(n);
  for (size_t i = 0; i < n; ++i) {
    std::copy_n(&position[3 * i], 3, g.at(kPosition, i));
    for (int k = 0; k < 4; ++k) g.at(kRotation, i)[k] = rotation[4 * i + size_t(k + 3) % 4];
    for (int k = 0; k < 3; ++k)
      g.at(kScaleLog, i)[k] = logarithms ? scale[3 * i + k] : std::log(scale[3 * i + k]);
    *g.at(kOpacityLogit, i) = LogitOfByteShare(opacity[i]);
  }
  for (int c = 0; c < CoefficientCount(g.degree); ++c) {
    const std::vector<float> color =
        ReadAttribute(document, primitive, SplatCoefficientName(c), 3, n);
    for (size_t i = 0; i < n; ++i)
      std::copy_n(&color[3 * i], 3, c == 0 ? g.at(kColorDc, i) : g.at(kColorRest, i) + 3 * (c - 1));
  }
  SettleSplats(g, notes);
  return g;
}

}  // namespace cosplat

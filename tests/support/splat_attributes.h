// Reads KHR_gaussian_splatting's attributes as any other program would: Gaussians in 3DGS's SH.
#pragma once

#include <cmath>
#include <string>

#include "splat/gaussians.h"
#include "splat/io/glb.h"

namespace cosplat::test {

inline Gaussians DecodeSplats(const GlbDocument& document, const GlbPrimitive& primitive) {
  const std::string prefix = "KHR_gaussian_splatting:";
  const auto read = [&](const std::string& name, int width) {
    return ReadValues<float>(document, primitive.attributes.at(name), width, name);
  };
  const auto position = read("POSITION", 3), rotation = read(prefix + "ROTATION", 4);
  const auto scale = read(prefix + "SCALE", 3), opacity = read(prefix + "OPACITY", 1);
  Gaussians g;
  g.basis = Basis::kSh;
  while (primitive.attributes.contains(prefix + "SH_DEGREE_" + std::to_string(g.degree + 1) +
                                       "_COEF_0"))
    ++g.degree;
  g.Resize(opacity.size());
  for (size_t i = 0; i < g.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = position[3 * i + k];
      g.at(kScaleLog, i)[k] = std::log(scale[3 * i + k]);
      g.at(kRotation, i)[k + 1] = rotation[4 * i + k];
    }
    g.at(kRotation, i)[0] = rotation[4 * i + 3];
    *g.at(kOpacityLogit, i) = std::log(opacity[i] / (1 - opacity[i]));
  }
  for (int l = 0, k = 0; l <= g.degree; ++l)
    for (int n = 0; n <= 2 * l; ++n, ++k) {
      const auto values =
          read(prefix + "SH_DEGREE_" + std::to_string(l) + "_COEF_" + std::to_string(n), 3);
      for (size_t i = 0; i < g.size(); ++i)
        for (int c = 0; c < 3; ++c) {
          float* color = k == 0 ? g.at(kColorDc, i) : g.at(kColorRest, i) + 3 * (k - 1);
          color[c] = values[3 * i + c];
        }
    }
  return g;
}

}  // namespace cosplat::test

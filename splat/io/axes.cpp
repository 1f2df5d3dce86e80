#include "splat/io/splat_primitive.h"
#include "splat/math/quat.h"
#include "splat/math/scalar.h"

namespace cosplat {
namespace {

int BandOf(int coefficient) {
  int band = 0;
  while (CoefficientCount(band) <= coefficient) ++band;
  return band;
}

}  // namespace

float GltfTurnSign(int coefficient) {
  const int l = BandOf(coefficient);
  const int m = coefficient - l * l - l;
  const float parity = (l + m) % 2 == 0 ? 1.0f : -1.0f;
  return m < 0 ? -parity : parity;
}

void TurnToGltfAxes(Gaussians& gaussians) {
  const math::Quat<float> turn{0, 1, 0, 0};
  const int rest = CoefficientCount(gaussians.degree) - 1;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    float* p = gaussians.at(kPosition, i);
    p[1] = -p[1];
    p[2] = -p[2];
    float* r = gaussians.at(kRotation, i);
    const auto q = math::Multiply(turn, math::Quat<float>{r[0], r[1], r[2], r[3]});
    r[0] = q.w;
    r[1] = q.x;
    r[2] = q.y;
    r[3] = q.z;
    float* color = gaussians.at(kColorRest, i);
    for (int k = 0; k < 3 * rest; ++k) color[k] *= GltfTurnSign(1 + k / 3);
  }
}

}  // namespace cosplat

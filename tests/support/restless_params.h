// A motion of the made head in which every parameter always changes.
#pragma once

#include <cmath>

#include "flame/model.h"

namespace cosplat::test {

// Every expression coefficient, every joint and the translation, another one in every frame.
inline FlameParams RestlessParams(const FlameModel& flame, int frame) {
  const float t = 0.4f * float(frame);
  FlameParams p;
  p.expression.resize(flame.expression_count);
  for (size_t k = 0; k < p.expression.size(); ++k) p.expression[k] = 0.15f * std::sin(t + float(k));
  for (int j = 0; j < kFlameJoints; ++j)
    for (int i = 0; i < 3; ++i) p.pose[j][i] = 0.06f * std::sin(1.3f * t + float(3 * j + i));
  for (int i = 0; i < 3; ++i) p.translation[i] = 0.002f * std::sin(0.9f * t + float(i));
  return p;
}

}  // namespace cosplat::test

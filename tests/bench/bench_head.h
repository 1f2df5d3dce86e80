// The made head with as many expressions as FLAME 2023 has, so that blend shapes cost what they do
// there.
#pragma once

#include "assets/head/procedural_head.h"
#include "splat/base/rng.h"

namespace cosplat {

inline ProceduralHead BenchHead() {
  constexpr int kExpressions = 100;
  constexpr float kNoise = 2e-5f;  // metres: size of the directions that the made head lacks
  ProceduralHead head = MakeProceduralHeadParts();
  FlameModel& model = head.model;
  Rng rng{3};
  const size_t own = model.expression_directions.size();
  model.expression_directions.resize(size_t(3) * model.vertex_count * kExpressions);
  for (size_t i = own; i < model.expression_directions.size(); ++i)
    model.expression_directions[i] = kNoise * rng.Normal();
  model.expression_count = kExpressions;
  return head;
}

}  // namespace cosplat

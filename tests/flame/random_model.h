// A small random FlameModel: no head, but every array full, so that a wrong index shows.
#pragma once

#include <cmath>
#include <random>

#include "flame/model.h"

namespace cosplat::test {

inline void FillRandom(std::vector<float>& values, size_t count, float scale, std::mt19937& rng) {
  std::normal_distribution<float> normal(0, scale);
  values.resize(count);
  for (float& x : values) x = normal(rng);
}

// Makes each row non-negative with sum 1.
inline void NormalizeRows(std::vector<float>& values, size_t columns) {
  for (size_t r = 0; r < values.size(); r += columns) {
    float sum = 0;
    for (size_t c = r; c < r + columns; ++c) sum += values[c] = std::abs(values[c]);
    for (size_t c = r; c < r + columns; ++c) values[c] /= sum;
  }
}

inline FlameModel RandomModel(int vertices = 12,
                              int shapes = 3,
                              int expressions = 4,
                              unsigned seed = 1) {
  std::mt19937 rng(seed);
  FlameModel model;
  model.name = "random";
  model.vertex_count = vertices;
  model.shape_count = shapes;
  model.expression_count = expressions;
  const size_t v = vertices;
  FillRandom(model.template_vertices, 3 * v, 1, rng);
  FillRandom(model.shape_directions, 3 * v * shapes, 0.1f, rng);
  FillRandom(model.expression_directions, 3 * v * expressions, 0.1f, rng);
  FillRandom(model.pose_directions, 3 * v * kFlamePoseFeatures, 0.1f, rng);
  FillRandom(model.joint_regressor, v * kFlameJoints, 1, rng);
  FillRandom(model.skinning_weights, v * kFlameJoints, 1, rng);
  NormalizeRows(model.joint_regressor, v);
  NormalizeRows(model.skinning_weights, kFlameJoints);
  for (int i = 0; i + 2 < vertices; i += 1) model.faces.push_back({i, i + 1, i + 2});
  return model;
}

}  // namespace cosplat::test

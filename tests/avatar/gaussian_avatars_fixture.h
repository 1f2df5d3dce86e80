// GaussianAvatars' files as its code writes them: made here, since no real one is at hand.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "flame/model.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"

namespace cosplat::test {

// A row of point_cloud.ply: in the frame and unit of its face.
struct BoundRow {
  std::array<float, 3> position{};
  std::array<float, 3> color_dc{};
  std::vector<float> color_rest;  // [3, coefficients - 1], channel-major
  float opacity_logit = 0;
  std::array<float, 3> scale_log{};
  std::array<float, 4> rotation{1, 0, 0, 0};
  float binding = 0;
};

// `count` random ones on faces below `faces`, up to about a face's size beside it.
inline std::vector<BoundRow> RandomRows(size_t count, size_t faces, unsigned seed, int degree = 3) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> normal;
  std::vector<BoundRow> rows(count);
  for (size_t i = 0; i < count; ++i) {
    BoundRow& row = rows[i];
    for (float& x : row.position) x = 0.4f * normal(rng);
    for (float& x : row.color_dc) x = normal(rng);
    row.color_rest.resize(3 * size_t((degree + 1) * (degree + 1) - 1));
    for (float& x : row.color_rest) x = 0.1f * normal(rng);
    row.opacity_logit = 1 + normal(rng);
    for (float& x : row.scale_log) x = -0.7f + 0.4f * normal(rng);
    for (float& x : row.rotation) x = normal(rng);
    row.binding = float(rng() % faces);
  }
  return rows;
}

// All properties are floats, the face's index too. names: in place of "binding_0".
inline void WriteBoundPly(const std::string& path,
                          const std::vector<BoundRow>& rows,
                          const std::string& binding_name = "binding_0") {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(rows.size()) + "\n";
  const auto property = [&](const std::string& name) { bytes += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"})
    property(name);
  for (size_t i = 0; !rows.empty() && i < rows[0].color_rest.size(); ++i)
    property("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2"}) property(name);
  for (const char* name : {"rot_0", "rot_1", "rot_2", "rot_3"}) property(name);
  if (!binding_name.empty()) property(binding_name);
  bytes += "end_header\n";
  const auto put = [&](const auto& numbers) {
    bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float));
  };
  for (const BoundRow& row : rows) {
    put(row.position);
    put(std::array<float, 3>{});
    put(row.color_dc);
    put(row.color_rest);
    put(std::array{row.opacity_logit});
    put(row.scale_log);
    put(row.rotation);
    if (!binding_name.empty()) put(std::array{row.binding});
  }
  WriteFileAtomically(path, bytes);
}

// flame_param.npz of `frames` frames: the arrays that GaussianAvatars keeps. offset_rows: vertices
// of static_offset, [1, V, 3] as there; all 0.5 mm along x.
inline Npz FlameParamOf(const std::vector<FlameParams>& frames,
                        const std::vector<float>& shape,
                        size_t expressions,
                        size_t offset_rows) {
  Npz npz("flame_param.npz");
  const size_t count = frames.size();
  const auto add = [&](const char* name, size_t width, const auto& numbers_of) {
    std::vector<float> values;
    for (const FlameParams& frame : frames) {
      std::vector<float> row = numbers_of(frame);
      row.resize(width);
      values.insert(values.end(), row.begin(), row.end());
    }
    npz.Add(name, {count, width}, values);
  };
  const auto joint = [](size_t j) {
    return [j](const FlameParams& f) {
      return std::vector<float>(f.pose[j].begin(), f.pose[j].end());
    };
  };
  npz.Add("shape", {shape.size()}, shape);
  add("expr", expressions, [](const FlameParams& f) { return f.expression; });
  add("rotation", 3, joint(0));
  add("neck_pose", 3, joint(1));
  add("jaw_pose", 3, joint(2));
  add("eyes_pose", 6, [](const FlameParams& f) {
    std::vector<float> eyes(f.pose[3].begin(), f.pose[3].end());
    eyes.insert(eyes.end(), f.pose[4].begin(), f.pose[4].end());
    return eyes;
  });
  add("translation", 3, [](const FlameParams& f) {
    return std::vector<float>(f.translation.begin(), f.translation.end());
  });
  std::vector<float> offset(3 * offset_rows);
  for (size_t i = 0; i < offset.size(); i += 3) offset[i] = 0.0005f;
  npz.Add("static_offset", {1, offset_rows, 3}, offset);
  npz.Add(
      "dynamic_offset", {count, offset_rows, 3}, std::vector<float>(count * offset_rows * 3, 0.0f));
  return npz;
}

// Expressions, a jaw that opens, and a turning head.
inline std::vector<FlameParams> SomeFrames(size_t count, size_t expressions, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> normal;
  std::vector<FlameParams> frames(count);
  for (FlameParams& frame : frames) {
    frame.expression.resize(expressions);
    for (float& x : frame.expression) x = 0.7f * normal(rng);
    frame.pose[0] = {0.1f + 0.1f * normal(rng), 0.2f * normal(rng), 0.05f * normal(rng)};
    frame.pose[1] = {0.1f * normal(rng), 0, 0};
    frame.pose[2] = {0.15f + 0.1f * std::abs(normal(rng)), 0, 0};
    frame.pose[3] = frame.pose[4] = {0, 0.2f * normal(rng), 0};
    for (float& x : frame.translation) x = 0.02f * normal(rng);
  }
  return frames;
}

// A model with as many vertices and faces as FLAME: a tube of 29 columns, and six vertices without
// faces. Its lips are where FLAME's numbers fall.
inline FlameModel FlameSizedTube(int shapes = 4, int expressions = 5) {
  constexpr int kColumns = 29, kRows = 173, kVertices = 5023;
  std::mt19937 rng(3);
  std::normal_distribution<float> normal(0, 0.002f);
  FlameModel model;
  model.name = "tube";
  model.vertex_count = kVertices;
  model.shape_count = shapes;
  model.expression_count = expressions;
  for (int v = 0; v < kVertices; ++v) {
    const float a = 6.2831853f * float(v % kColumns) / kColumns;
    model.template_vertices.push_back(0.08f * std::sin(a));
    model.template_vertices.push_back(0.001f * float(v / kColumns) - 0.1f);
    model.template_vertices.push_back(0.08f * std::cos(a));
  }
  for (int r = 0; r + 1 < kRows; ++r)
    for (int c = 0; c < kColumns; ++c) {
      const int32_t at = r * kColumns + c, next = r * kColumns + (c + 1) % kColumns;
      model.faces.push_back({at, next, at + kColumns});
      model.faces.push_back({next, next + kColumns, at + kColumns});
    }
  const auto fill = [&](std::vector<float>& values, int count) {
    values.resize(3 * size_t(kVertices) * size_t(count));
    for (float& x : values) x = normal(rng);
  };
  fill(model.shape_directions, shapes);
  fill(model.expression_directions, expressions);
  fill(model.pose_directions, kFlamePoseFeatures);
  model.joint_regressor.assign(size_t(kFlameJoints) * kVertices, 0);
  for (int j = 0; j < kFlameJoints; ++j)
    model.joint_regressor[size_t(j) * kVertices + 100 * size_t(j + 1)] = 1;
  for (int v = 0; v < kVertices; ++v) {
    std::array<float, kFlameJoints> weights{0.2f, 0.5f, 0.3f, 0, 0};
    model.skinning_weights.insert(model.skinning_weights.end(), weights.begin(), weights.end());
  }
  return model;
}

}  // namespace cosplat::test

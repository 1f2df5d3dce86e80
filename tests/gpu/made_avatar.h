// An avatar on a ball of about FLAME's size, with a model that poses it, for measurements where
// there is no FLAME.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "apps/study/bench/synthetic_view.h"
#include "avatar/model/avatar_model.h"
#include "avatar/play/rig_poser.h"
#include "flame/kernels/pose.h"
#include "flame/math/rodrigues.h"
#include "splat/base/rng.h"
#include "tests/avatar/meshes.h"

namespace cosplat::test {

constexpr float kRadius = 0.12f, kDistance = 0.55f;  // metres: half of the image
constexpr int kPoses = 8, kExpressions = 100;

// FLAME's arrays for a ball.
struct MadeModel {
  std::vector<float> expression_directions, pose_directions, weights;
  PosingArrays<float> arrays;
};

struct MadeAvatar {
  AvatarModel model;
  MadeModel flame;
  std::vector<AvatarRig> rigs;
  std::vector<std::vector<float>> poses;  // what the rigs make of the mesh
  Camera camera;
  Image8 photograph;
  RenderSettings settings;
};

// Directions of waves, and weights that go from joint to joint down the ball.
inline void MakeModel(const CanonicalMesh& mesh, MadeModel& model) {
  const size_t numbers = mesh.vertices.size();
  for (size_t i = 0; i < kExpressions * numbers; ++i)
    model.expression_directions.push_back(
        0.003f * std::sin(40 * mesh.vertices[i % numbers] + float(i / numbers)));
  for (size_t i = 0; i < kFlamePoseFeatures * numbers; ++i)
    model.pose_directions.push_back(0.002f *
                                    std::cos(30 * mesh.vertices[i % numbers] + float(i / numbers)));
  for (size_t v = 0; v < numbers / 3; ++v)
    for (int j = 0; j < kFlameJoints; ++j) {
      const float place = 2 * (1 + mesh.vertices[3 * v + 1] / kRadius);  // 0 to 4
      model.weights.push_back(std::max(0.0f, 1 - std::abs(place - float(j))));
    }
  model.arrays = {numbers / 3,
                  kExpressions,
                  mesh.vertices.data(),
                  model.expression_directions.data(),
                  model.pose_directions.data(),
                  model.weights.data()};
}

// Every coefficient and joint another one in every pose.
inline FlameRig<float> MakeRig(int pose) {
  FlameRig<float> rig;
  std::array<math::Mat3<float>, kFlameJoints> local;
  std::array<math::Vec3<float>, kFlameJoints> joints{};
  for (int k = 0; k < kExpressions; ++k) rig.terms.push_back({k, 0.5f * std::sin(float(pose + k))});
  rig.expression_terms = rig.terms.size();
  for (int j = 0; j < kFlameJoints; ++j) {
    joints[j][1] = kRadius * (0.5f * float(j) - 1);
    local[j] = flame_math::Rodrigues<float>({0.1f * std::sin(float(pose + j)), 0.1f, 0.05f});
    for (int i = 0; j > 0 && i < 9; ++i)
      rig.terms.push_back({9 * (j - 1) + i, local[j].m[i] - (i % 4 == 0 ? 1.0f : 0.0f)});
  }
  rig.transforms = flame_math::PoseJoints(local, joints, FlameModel{}.parents);
  return rig;
}

inline std::vector<float> PosedByCpu(const MadeModel& model, const FlameRig<float>& rig) {
  std::vector<float> unskinned(3 * model.arrays.vertex_count), vertices(unskinned.size());
  const flame_math::BlendShapesKernel<float> blend{model.arrays,
                                                   rig.terms.data(),
                                                   rig.expression_terms,
                                                   rig.terms.size() - rig.expression_terms,
                                                   unskinned.data()};
  for (size_t i = 0; i < unskinned.size(); ++i) blend(i);
  const flame_math::SkinKernel<float> skin(
      rig, model.arrays.weights, unskinned.data(), vertices.data());
  for (size_t v = 0; v < model.arrays.vertex_count; ++v) skin(v);
  return vertices;
}

// Gaussians as wide as their even spacing on a ball that bulges here and there.
inline MadeAvatar MakeAvatar(size_t count, int side, int levels) {
  SyntheticView view = MakeSyntheticView(count, side, side, 1);
  MadeAvatar made;
  made.model.mesh = SphereMesh(levels, kRadius);
  made.model.gaussians = std::move(view.start);
  made.photograph = std::move(view.frame.target);
  Rng rng{7};
  const float spacing = std::sqrt(4 * 3.14159f * kRadius * kRadius / float(count));
  for (size_t i = 0; i < count; ++i) {
    made.model.embedding.triangle.push_back(int32_t(rng.Below(made.model.mesh.faces.size())));
    const float s = std::sqrt(float(rng.Uniform())), t = float(rng.Uniform());
    made.model.embedding.barycentric.push_back({1 - s, s * t});
    for (int k = 0; k < 3; ++k) {
      made.model.gaussians.at(kPosition, i)[k] = 0;
      made.model.gaussians.at(kScaleLog, i)[k] = std::log(spacing * (k == 2 ? 0.2f : 0.7f));
    }
  }
  MakeModel(made.model.mesh, made.flame);
  for (int pose = 0; pose < kPoses; ++pose) {
    made.rigs.push_back({MakeRig(pose), kMeanBustPose, {}});
    made.poses.push_back(PosedByCpu(made.flame, made.rigs.back().flame));
  }
  made.camera = view.frame.camera;
  made.camera.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  made.camera.translation = {0, 0, kDistance};
  made.camera.fx = made.camera.fy = 0.5f * float(side) * kDistance / (2 * kRadius);
  made.settings = {{0, 0, 0}, made.model.gaussians.degree};
  return made;
}

}  // namespace cosplat::test

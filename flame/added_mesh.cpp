#include "flame/added_mesh.h"

namespace cosplat {
namespace {

constexpr int kNeckJoint = 1, kJawJoint = 2;

// [count, V, 3] -> [count, V + new, 3]; f(direction of one vertex, new vertex) gives the new ones.
template <class F>
void Extend(std::vector<float>& directions,
            int count,
            int vertex_count,
            const std::vector<AddedVertex>& added,
            const F& f) {
  const size_t row = 3 * size_t(vertex_count);
  std::vector<float> out;
  out.reserve(size_t(count) * (row + 3 * added.size()));
  for (int k = 0; k < count; ++k) {
    const float* from = &directions[size_t(k) * row];
    out.insert(out.end(), from, from + row);
    for (const AddedVertex& v : added)
      for (int axis = 0; axis < 3; ++axis) out.push_back(f(from + axis, v));
  }
  directions = std::move(out);
}

// Zero in the regressor: the joints stay where they are.
void ExtendRegressor(size_t added, FlameModel& model) {
  std::vector<float> regressor;
  for (int j = 0; j < kFlameJoints; ++j) {
    const auto row = model.joint_regressor.begin() + long(j) * model.vertex_count;
    regressor.insert(regressor.end(), row, row + model.vertex_count);
    regressor.insert(regressor.end(), added, 0.0f);
  }
  model.joint_regressor = std::move(regressor);
}

}  // namespace

void AddToMesh(const std::vector<AddedVertex>& vertices,
               const std::vector<std::array<int32_t, 3>>& faces,
               FlameModel& model) {
  const auto shape = [](const float* direction, const AddedVertex& v) {
    float sum = 0;
    for (const auto& [of, weight] : v.shape_of) sum += weight * direction[3 * size_t(of)];
    return sum;
  };
  const auto motion = [](const float* direction, const AddedVertex& v) {
    return v.motion * direction[3 * size_t(v.moves_with)];
  };
  const int own = model.vertex_count;
  Extend(model.shape_directions, model.shape_count, own, vertices, shape);
  Extend(model.expression_directions, model.expression_count, own, vertices, motion);
  Extend(model.pose_directions, kFlamePoseFeatures, own, vertices, motion);
  ExtendRegressor(vertices.size(), model);
  for (std::array<int32_t, 3> face : faces) {
    for (int32_t& v : face) v += own;
    model.faces.push_back(face);
  }
  for (const AddedVertex& v : vertices) {
    model.template_vertices.insert(model.template_vertices.end(), v.place.begin(), v.place.end());
    std::array<float, kFlameJoints> weights{};
    weights[kNeckJoint] = 1 - v.jaw;
    weights[kJawJoint] = v.jaw;
    model.skinning_weights.insert(model.skinning_weights.end(), weights.begin(), weights.end());
  }
  model.vertex_count += int(vertices.size());
}

}  // namespace cosplat

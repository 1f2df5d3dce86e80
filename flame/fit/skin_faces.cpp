#include "flame/fit/skin_faces.h"

#include <algorithm>

namespace cosplat::internal {

std::vector<std::array<int32_t, 3>> SkinFaces(const FlameModel& model) {
  const auto is_skin = [&](int32_t v) {
    const float* const weight = &model.skinning_weights[kFlameJoints * size_t(v)];
    return v < model.own_vertex_count() && weight[3] + weight[4] <= 0.01f;
  };
  std::vector<std::array<int32_t, 3>> faces;
  for (const std::array<int32_t, 3>& face : model.faces)
    if (std::all_of(face.begin(), face.end(), is_skin)) faces.push_back(face);
  return faces;
}

}  // namespace cosplat::internal

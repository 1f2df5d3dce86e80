// The head without the inside of its mouth, as FLAME's mesh is: what a video shows between the lips
// differs from person to person, and teeth that are not theirs would be painted with their lips
// (flame/mouth.h adds some that stay behind them).

#include <algorithm>

#include "assets/head/rig.h"

namespace cosplat::procedural {
namespace {

// values: [rows, V, width]
template <class T>
void Keep(const std::vector<int>& kept, size_t count, size_t width, std::vector<T>& values) {
  std::vector<T> rest;
  for (size_t row = 0; row < values.size(); row += count * width)
    for (const int v : kept)
      for (size_t k = 0; k < width; ++k) rest.push_back(values[row + size_t(v) * width + k]);
  values = std::move(rest);
}

void Renumber(const std::vector<int>& place, std::vector<int>& vertices) {
  std::erase_if(vertices, [&](int v) { return place[size_t(v)] < 0; });
  for (int& v : vertices) v = place[size_t(v)];
}

}  // namespace

void OpenMouth(ProceduralHead& head) {
  HeadMesh& mesh = head.mesh;
  FlameModel& model = head.model;
  const size_t count = mesh.labels.size();
  std::vector<int> kept, place(count, -1);
  for (size_t v = 0; v < count; ++v)
    if (mesh.labels[v].mouth_ring < kVestibule) {
      place[v] = int(kept.size());
      kept.push_back(int(v));
    }
  Keep(kept, count, 1, mesh.positions);
  Keep(kept, count, 1, mesh.labels);
  Keep(kept, count, 1, head.ambient_occlusion);
  for (auto& face : mesh.faces)
    for (int32_t& v : face) v = place[size_t(v)];
  std::erase_if(mesh.faces,
                [](const auto& face) { return *std::min_element(face.begin(), face.end()) < 0; });
  for (std::vector<int>* loop :
       {&mesh.neck_loop, &mesh.throat_loop, &mesh.lid_loops[0], &mesh.lid_loops[1], &mesh.lip_loop})
    Renumber(place, *loop);
  model.vertex_count = int(kept.size());
  model.faces = mesh.faces;
  Keep(kept, count, 3, model.template_vertices);
  Keep(kept, count, 3, model.shape_directions);
  Keep(kept, count, 3, model.expression_directions);
  Keep(kept, count, 3, model.pose_directions);
  Keep(kept, count, 1, model.joint_regressor);
  Keep(kept, count, kFlameJoints, model.skinning_weights);
}

}  // namespace cosplat::procedural

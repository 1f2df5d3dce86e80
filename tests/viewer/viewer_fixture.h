// A painted avatar of the made head and a small scene, as the viewer takes them.
#pragma once

#include <utility>
#include <vector>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "apps/viewer/orbit_camera.h"
#include "apps/viewer/stage.h"
#include "assets/head/procedural_head.h"
#include "tests/support/random_gaussians.h"

namespace cosplat::test {

// Once per process; copy what is to be moved.
inline const viewer::Content& PaintedHead() {
  static const viewer::Content content = [] {
    const ProceduralHead head = MakeProceduralHeadParts();
    viewer::Content made;
    made.title = "head";
    made.avatar.emplace();
    made.avatar->flame = head.model;
    made.avatar->model = PaintedAvatar(head, 1500);
    made.start = viewer::BeforeHead(made.avatar->model.mesh.vertices, {0, 0, 0});
    return made;
  }();
  return content;
}

inline viewer::Content SceneOf(Gaussians gaussians) {
  viewer::Content content;
  content.title = "scene";
  content.scene = std::move(gaussians);
  content.background = {0, 0, 0};
  content.start = viewer::BeforeSplats("scene", content.scene);
  return content;
}
inline viewer::Content SmallScene() { return SceneOf(RandomGaussians(300, 1, Basis::kSh, 1)); }

// Faces of a mouth that opens, `count` of them.
inline std::vector<FlameParams> OpeningMouth(int count) {
  std::vector<FlameParams> faces(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) faces[size_t(i)].pose[2][0] = 0.4f * float(i) / float(count);
  return faces;
}

}  // namespace cosplat::test

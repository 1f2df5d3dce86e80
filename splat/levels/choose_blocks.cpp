#include "splat/levels/choose_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <utility>

#include "splat/config.h"

namespace cosplat {
namespace {

// px around the image: the renderer's blur reaches that far.
constexpr float kRim = 4;

// The half-spaces whose intersection is what a camera sees.
class Frustum {
 public:
  explicit Frustum(const Camera& c) {
    const std::array<std::array<float, 3>, 5> in_camera{{
        {c.fx, 0, c.cx + kRim},
        {-c.fx, 0, float(c.width) + kRim - c.cx},
        {0, c.fy, c.cy + kRim},
        {0, -c.fy, float(c.height) + kRim - c.cy},
        {0, 0, 1},
    }};
    for (size_t p = 0; p < planes_.size(); ++p) {
      const std::array<float, 3>& n = in_camera[p];
      for (size_t i = 0; i < 3; ++i)
        planes_[p].normal[i] =
            c.rotation[i] * n[0] + c.rotation[3 + i] * n[1] + c.rotation[6 + i] * n[2];
      planes_[p].offset =
          n[0] * c.translation[0] + n[1] * c.translation[1] + n[2] * c.translation[2];
    }
    planes_[4].offset -= c.near_plane;
  }

  // False only if nothing of the box is inside.
  bool Sees(const LevelBlock& box) const {
    return std::all_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
      float farthest = plane.offset;
      for (size_t i = 0; i < 3; ++i)
        farthest += plane.normal[i] * (plane.normal[i] > 0 ? box.max[i] : box.min[i]);
      return farthest >= 0;
    });
  }

 private:
  struct Plane {
    std::array<float, 3> normal;  // in the world
    float offset;
  };
  std::array<Plane, 5> planes_;
};

float DistanceTo(const LevelBlock& box, const std::array<float, 3>& center, float min) {
  float squared = 0;
  for (size_t i = 0; i < 3; ++i) {
    const float outside = std::max({box.min[i] - center[i], center[i] - box.max[i], 0.0f});
    squared += outside * outside;
  }
  return std::max(std::sqrt(squared), min);
}

}  // namespace

void ChooseBlocks(const SceneLevels& levels,
                  const Camera& camera,
                  const LevelLimits& limits,
                  std::vector<uint32_t>& chosen) {
  chosen.clear();
  const Frustum frustum(camera);
  const std::array<float, 3> center = camera.Center();
  const float focal = std::max(camera.fx, camera.fy);
  using Seen = std::pair<float, uint32_t>;  // px of coarseness, block
  std::priority_queue<Seen> coarsest;
  size_t count = 0;
  const auto add = [&](uint32_t b) {
    const LevelBlock& block = levels.blocks[b];
    coarsest.push({block.coarseness * focal / DistanceTo(block, center, camera.near_plane), b});
    count += block.count;
  };
  const auto sees = [&](uint32_t b) { return frustum.Sees(levels.blocks[b]); };
  const auto all = uint32_t(levels.blocks.size()) - 1;
  if (!levels.blocks.empty() && sees(all)) add(all);
  while (!coarsest.empty()) {
    const auto [coarseness, b] = coarsest.top();
    coarsest.pop();
    const LevelBlock& block = levels.blocks[b];
    std::array<uint32_t, 2> seen{};
    size_t seen_count = 0, finer = count - block.count;
    const bool refine = block.children > 0 && coarseness > limits.coarseness;
    for (uint32_t k = 0; refine && k < block.children; ++k)
      if (sees(block.first_child + k)) {
        seen[seen_count++] = block.first_child + k;
        finer += levels.blocks[block.first_child + k].count;
      }
    if (!refine || finer > limits.max) {
      chosen.push_back(b);
      continue;
    }
    count -= block.count;
    for (size_t k = 0; k < seen_count; ++k) add(seen[k]);
  }
  std::sort(chosen.begin(), chosen.end());
}

}  // namespace cosplat

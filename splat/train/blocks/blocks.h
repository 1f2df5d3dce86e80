// Splits a static scene by place into blocks that are trained by themselves.
//
// Planes divide space in two again and again, as a BSP tree (Fuchs et al. 1980, *On visible surface
// generation by a priori tree structures*): its leaves are the blocks, convex, without a bound
// towards the outside, so that the background belongs to one of them, too. A camera sees them in an
// order that its place alone decides, so that images of blocks add up to one of the scene
// (splat/train/blocks/layers.h).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/base/state_file.h"
#include "splat/device/buffer.h"

namespace cosplat {

// Points p with normal . p < offset are below it.
struct BlockPlane {
  std::array<float, 3> normal{};
  float offset = 0;
  // A plane by its index or, if negative, block ~index.
  std::array<int32_t, 2> side{};  // below, above
};

struct SceneBlocks {
  std::vector<BlockPlane> planes;  // the first divides all; empty: one block
  size_t count() const { return planes.size() + 1; }
  size_t BlockOf(const float* point) const;
  // All blocks in the order in which rays from `eye` reach them.
  std::vector<uint32_t> FrontToBack(const std::array<float, 3>& eye) const;
};

// Into blocks of equally many of these points ([P, 3]), as equal work. Each plane is perpendicular
// to the principal direction of its points, of which those that are further from their median than
// half of them are count as if they were that far: a distant background does not decide. Throws
// Error if there are not as many different places.
SceneBlocks SplitByPlace(View<const float> points, size_t blocks);

// For `count` blocks. Reading throws Error if the planes are not a tree.
void Serialize(StateArchive& archive, size_t count, SceneBlocks& blocks);

}  // namespace cosplat

// A scene at several levels of detail, for looking at more Gaussians than can be drawn in time.
//
// Gaussians -> BuildLevels -> SceneLevels -> ChooseBlocks (splat/levels/choose_blocks.h)
//   -> LevelRenderer (splat/levels/level_renderer.h) -> image
//
// Level 0 holds the scene's Gaussians in the order of a k-d tree; each Gaussian of level l + 1
// stands for two neighbours of level l (splat/levels/merge.h), up to a level of one block. A block
// is a range of kLevelBlock Gaussians of a level; its children are the two blocks that it stands
// for. Source: Kerbl et al. 2024 (hierarchical 3DGS), with blocks of many Gaussians in place of
// nodes of one, so that choosing takes no time and a block is one piece of memory or disk.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "splat/gaussians.h"

namespace cosplat {

constexpr size_t kLevelBlock = 1024;
// Logarithm of world units, and world units: squares of both stay finite.
constexpr float kMaxLevelScaleLog = 40, kMaxLevelPosition = 1e18f;

struct LevelBlock {
  // The box of all that is drawn of the block's Gaussians, world units.
  std::array<float, 3> min{}, max{};
  // World units: how far the scene's Gaussians are from those that stand for them here, root of the
  // mean square; not less than that of a child. 0 at level 0.
  float coarseness = 0;
  uint32_t count = 0;        // Gaussians, 1 to kLevelBlock
  uint32_t first_child = 0;  // index of the block; its children follow each other
  uint32_t children = 0;     // 0 to 2
};

struct SceneLevels {
  // What every Gaussian has in common: no more than this is set, and there are no values.
  Gaussians layout;
  std::vector<LevelBlock> blocks;  // by level, the finest first; the last one stands for all
  // The blocks' values one after the other, each with its attributes one after the other as in
  // Gaussians::values. Memory of this process or of a file (splat/levels/levels_file.h).
  std::shared_ptr<const float> values;
  std::string file;                 // that the values lie in; empty if none
  std::vector<uint32_t> checksums;  // [blocks] CRC-32 of the values; only of a file
  std::vector<uint64_t> offsets;    // [blocks] in `values`

  size_t width() const;  // floats per Gaussian
  size_t size() const;   // of the scene: Gaussians of level 0
  const float* ValuesOf(size_t block) const { return values.get() + offsets[block]; }
  // Throws Error if the block's values are not those that were written.
  void CheckValues(size_t block) const;
  // The Gaussians that stand for all, at most kLevelBlock.
  Gaussians Coarsest() const;

  // Sets counts, children and offsets of the blocks of a scene of so many Gaussians, which follow
  // from their number and the layout alone, and returns the number of floats of all levels.
  uint64_t LayOut(size_t gaussians);
};

// Takes twice the memory of the scene, which it frees before the coarser levels are made. Gaussians
// that are never rendered are left out: with non-finite parameters, an opacity below kMinAlpha, no
// rotation, or standard deviations beyond kMaxLevelScaleLog; and those farther out than
// kMaxLevelPosition. An empty scene has no blocks.
// The same result for any number of threads. Throws Error if the Gaussians have individual
// smoothing (BakeSmoothing).
SceneLevels BuildLevels(Gaussians scene);

}  // namespace cosplat

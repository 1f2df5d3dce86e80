// Renders a scene's levels on the CPU. Blocks that were drawn in the last image are where they
// were; others are copied over those that are no longer drawn.
#pragma once

#include <memory>
#include <vector>

#include "splat/levels/choose_blocks.h"
#include "splat/levels/scene_levels.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

class LevelRenderer {
 public:
  explicit LevelRenderer(SceneLevels levels);

  const SceneLevels& levels() const { return levels_; }

  // Throws Error as Rasterizer::Forward and Select. Images are the same whatever was drawn before,
  // but for Gaussians of exactly the same depth.
  void Draw(const Camera& camera,
            const RenderSettings& settings,
            const LevelLimits& limits,
            RenderedImage& image);

  // The Gaussians of the image that Draw would render, some of them invisible. They stay until the
  // next call. Throws Error if the file of the levels is damaged.
  const Gaussians& Select(const Camera& camera, const LevelLimits& limits);

  // Gaussians drawn in the last image, and those among them that had to be copied.
  size_t drawn() const { return drawn_; }
  size_t copied() const { return copied_; }

 private:
  void Bring(const std::vector<uint32_t>& chosen);
  void Copy(uint32_t block, uint32_t slot);

  SceneLevels levels_;
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  Gaussians slots_;                 // kLevelBlock for each slot
  std::vector<uint32_t> block_of_;  // [slots] or kNone
  std::vector<uint32_t> chosen_, missing_, free_;
  std::vector<uint8_t> has_slot_, is_chosen_;  // [blocks]
  size_t drawn_ = 0, copied_ = 0;
};

}  // namespace cosplat

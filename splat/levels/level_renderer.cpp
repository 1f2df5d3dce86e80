#include "splat/levels/level_renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace cosplat {
namespace {

constexpr uint32_t kNone = ~uint32_t{0};
// A logit that no renderer draws.
constexpr float kInvisible = -50;

}  // namespace

LevelRenderer::LevelRenderer(SceneLevels levels)
    : levels_(std::move(levels)),
      rasterizer_(MakeCpuRasterizer()),
      tape_(rasterizer_->MakeTape(false)),
      slots_(levels_.layout),
      has_slot_(levels_.blocks.size()),
      is_chosen_(levels_.blocks.size()) {}

const Gaussians& LevelRenderer::Select(const Camera& camera, const LevelLimits& limits) {
  ChooseBlocks(levels_, camera, limits, chosen_);
  Bring(chosen_);
  return slots_;
}

void LevelRenderer::Draw(const Camera& camera,
                         const RenderSettings& settings,
                         const LevelLimits& limits,
                         RenderedImage& image) {
  Select(camera, limits);
  rasterizer_->Forward(ViewOf(slots_), slots_.basis, camera, settings, image, *tape_);
}

void LevelRenderer::Bring(const std::vector<uint32_t>& chosen) {
  const auto find_missing = [&] {
    missing_.clear();
    for (const uint32_t b : chosen)
      if (!has_slot_[b]) missing_.push_back(b);
  };
  find_missing();
  // What fails comes first, so that the slots stay as they were.
  tbb::parallel_for(
      size_t(0), missing_.size(), [&](size_t i) { levels_.CheckValues(missing_[i]); });
  // With more than half of the slots free, projecting them costs more than beginning anew.
  if (block_of_.size() > 2 * chosen.size() + 16) {
    block_of_.clear();
    std::fill(has_slot_.begin(), has_slot_.end(), uint8_t{0});
    find_missing();
  }
  for (const uint32_t b : chosen) is_chosen_[b] = 1;
  free_.clear();
  for (uint32_t slot = 0; slot < block_of_.size(); ++slot) {
    const uint32_t block = block_of_[slot];
    if (block != kNone && is_chosen_[block]) continue;
    if (block != kNone) has_slot_[block] = 0;
    block_of_[slot] = kNone;
    free_.push_back(slot);
  }
  for (const uint32_t b : chosen) is_chosen_[b] = 0;
  const size_t more = missing_.size() - std::min(missing_.size(), free_.size());
  slots_.Resize((block_of_.size() + more) * kLevelBlock);
  for (size_t i = 0; i < more; ++i) {
    free_.push_back(uint32_t(block_of_.size()));
    block_of_.push_back(kNone);
  }
  tbb::parallel_for(size_t(0), free_.size(), [&](size_t i) {
    Copy(i < missing_.size() ? missing_[i] : kNone, free_[i]);
  });
  drawn_ = copied_ = 0;
  for (const uint32_t b : chosen) drawn_ += levels_.blocks[b].count;
  for (const uint32_t b : missing_) {
    copied_ += levels_.blocks[b].count;
    has_slot_[b] = 1;
  }
}

// kNone: nothing to be seen.
void LevelRenderer::Copy(uint32_t block, uint32_t slot) {
  block_of_[slot] = block;
  size_t count = 0;
  if (block != kNone) {
    count = levels_.blocks[block].count;
    const float* from = levels_.ValuesOf(block);
    for (int a = 0; a < kAttributeCount; ++a) {
      const size_t floats = count * size_t(slots_.width(a));
      std::copy_n(
          from, floats, slots_.values[a].data() + slot * kLevelBlock * size_t(slots_.width(a)));
      from += floats;
    }
  }
  float* opacity = slots_.values[kOpacityLogit].data() + slot * kLevelBlock;
  std::fill(opacity + count, opacity + kLevelBlock, kInvisible);
}

}  // namespace cosplat

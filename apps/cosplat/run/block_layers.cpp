#include "apps/cosplat/run/block_layers.h"

#include <algorithm>
#include <map>
#include <utility>

#include "splat/render/rasterizer.h"
#include "splat/train/blocks/block_target.h"
#include "splat/train/blocks/layers.h"

namespace cosplat {
namespace {

// A block trains on the views of which it covers at least this share, or this part of its largest
// share if that is less: so early, a block may be hardly opaque.
constexpr float kMinShare = 0.01f;
constexpr float kMinPart = 0.25f;

}  // namespace

void BlockLayers::Draw(size_t first, size_t step, const std::function<bool()>& goes_on) const {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape(false);
  RenderedImage image;
  const auto layer_of = [&](const Gaussians& gaussians, size_t view) {
    rasterizer->Forward(ViewOf(gaussians),
                        gaussians.basis,
                        scene_.camera(view),
                        {{0, 0, 0}, gaussians.degree},
                        image,
                        *tape);
    return LayerOf(image);
  };
  std::vector<std::vector<uint32_t>> shown(scene_.frame_count());
  for (uint32_t b = 0; b < blocks_.count() && goes_on(); ++b) {
    const Gaussians gaussians = files_.ReadBlock(b);
    for (size_t v = first; v < shown.size() && goes_on(); v += step) {
      const Image8 layer = layer_of(gaussians, v);
      files_.WriteLayer(b, v, LayerKind::kOwn, layer);
      if (!layer.empty()) shown[v].push_back(b);
    }
  }
  std::map<std::vector<uint32_t>, std::vector<size_t>> views;  // by the blocks that they show
  for (size_t v = first; v < shown.size(); v += step) views[shown[v]].push_back(v);
  for (const auto& [blocks, own] : views) {
    if (!goes_on()) return;
    const Gaussians gaussians = files_.ReadBlocks(blocks);
    for (size_t i = 0; i < own.size() && goes_on(); ++i)
      files_.WriteLayer(kWholeScene, own[i], LayerKind::kOwn, layer_of(gaussians, own[i]));
  }
}

std::vector<std::vector<uint32_t>> BlockLayers::ChooseViews() const {
  const size_t blocks = blocks_.count(), count = scene_.frame_count();
  std::vector<float> share(blocks * count), largest(blocks, 0.0f);
  for (size_t v = 0; v < count; ++v) {
    LayerStack stack;
    for (const uint32_t b : OrderIn(v)) {
      share[b * count + v] = stack.Add(Read(b, v));
      largest[b] = std::max(largest[b], share[b * count + v]);
    }
  }
  std::vector<std::vector<uint32_t>> views(blocks);
  for (size_t b = 0; b < blocks; ++b) {
    const float min = std::min(kMinShare, kMinPart * largest[b]);
    for (size_t v = 0; v < count; ++v)
      if (share[b * count + v] >= min) views[b].push_back(uint32_t(v));
  }
  return views;
}

void BlockLayers::PutTogether(size_t block,
                              const std::vector<uint32_t>& views,
                              const ExposureState& exposures,
                              size_t first,
                              size_t step,
                              const std::function<bool()>& goes_on) const {
  for (size_t i = first; i < views.size() && goes_on(); i += step) {
    const uint32_t view = views[i];
    FrameLayers others;
    LayerStack stack;
    for (const uint32_t other : OrderIn(view)) {
      if (other == block)
        others.front = std::exchange(stack, {}).Together();
      else
        stack.Add(Read(other, view));
    }
    others.behind = stack.Together();
    Exposure exposure = kIdentityExposure;
    if (exposures.value.size() > 0)
      std::copy_n(exposures.value.data() + i * exposure.size(), exposure.size(), exposure.data());
    TrainFrame scratch;
    const TrainFrame& frame = Loaded(scene_.frames()[view], scratch);
    const Image8 target =
        TargetOfBlock(frame.target, others, Read(block, view), Read(kWholeScene, view), exposure);
    files_.WriteLayer(block, view, LayerKind::kFront, others.front);
    files_.WriteLayer(block, view, LayerKind::kBehind, others.behind);
    files_.WriteLayer(block, view, LayerKind::kTarget, target);
    files_.WriteLayer(block, view, LayerKind::kIgnored, frame.ignored);
  }
}

std::vector<TrainFrame> BlockLayers::FramesOf(size_t block,
                                              const std::vector<uint32_t>& views) const {
  std::vector<TrainFrame> frames;
  for (const uint32_t view : views) {
    const auto read = [this, view, block] {
      TrainFrame frame{scene_.camera(view),
                       Read(block, view, LayerKind::kTarget),
                       Read(block, view, LayerKind::kIgnored)};
      frame.layers = {Read(block, view, LayerKind::kFront), Read(block, view, LayerKind::kBehind)};
      return frame;
    };
    frames.push_back({scene_.camera(view), {}, {}, read});
  }
  return frames;
}

void BlockLayers::RemoveTogether(size_t block, const std::vector<uint32_t>& views) const {
  for (const uint32_t view : views)
    for (const LayerKind kind :
         {LayerKind::kFront, LayerKind::kBehind, LayerKind::kTarget, LayerKind::kIgnored})
      files_.RemoveLayer(block, view, kind);
}

}  // namespace cosplat

#include "apps/cosplat/run/block_layers.h"

#include <algorithm>
#include <utility>

#include "splat/render/rasterizer.h"
#include "splat/train/block_target.h"
#include "splat/train/layers.h"

namespace cosplat {
namespace {

// A block trains on the views of which it covers at least this share, or this part of its largest
// share if that is less: so early, a block may be hardly opaque.
constexpr float kLeastShare = 0.01f;
constexpr float kLeastPart = 0.25f;

}  // namespace

void BlockLayers::Draw(size_t block,
                       size_t first,
                       size_t step,
                       const std::function<bool()>& goes_on) const {
  const Gaussians gaussians = files_.ReadBlock(block);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape(false);
  RenderedImage image;
  for (size_t v = first; v < scene_.frame_count() && goes_on(); v += step) {
    rasterizer->Forward(ViewOf(gaussians),
                        gaussians.basis,
                        scene_.camera(v),
                        {{0, 0, 0}, gaussians.degree},
                        image,
                        *tape);
    files_.WriteLayer(block, v, LayerKind::kOwn, LayerOf(image));
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
    const float least = std::min(kLeastShare, kLeastPart * largest[b]);
    for (size_t v = 0; v < count; ++v)
      if (share[b * count + v] >= least) views[b].push_back(uint32_t(v));
  }
  return views;
}

void BlockLayers::PutTogether(size_t block,
                              const std::vector<uint32_t>& views,
                              size_t first,
                              size_t step,
                              const std::function<bool()>& goes_on) const {
  for (size_t i = first; i < views.size() && goes_on(); i += step) {
    LayerStack stack;
    for (const uint32_t other : OrderIn(views[i])) {
      if (other == block)
        files_.WriteLayer(block, views[i], LayerKind::kFront, std::exchange(stack, {}).Together());
      else
        stack.Add(Read(other, views[i]));
    }
    files_.WriteLayer(block, views[i], LayerKind::kBehind, stack.Together());
  }
}

std::vector<TrainFrame> BlockLayers::FramesOf(size_t block,
                                              const std::vector<uint32_t>& views,
                                              const ExposureState& exposures) const {
  std::vector<TrainFrame> frames;
  for (size_t i = 0; i < views.size(); ++i) {
    const uint32_t view = views[i];
    Exposure exposure = kIdentityExposure;
    if (exposures.value.size() > 0)
      std::copy_n(exposures.value.data() + i * exposure.size(), exposure.size(), exposure.data());
    const auto read = [this, view, block, exposure] {
      TrainFrame scratch;
      const TrainFrame& frame = Loaded(scene_.frames()[view], scratch);
      TrainFrame shown{frame.camera, {}, frame.ignored};
      shown.layers = {Read(block, view, LayerKind::kFront), Read(block, view, LayerKind::kBehind)};
      shown.target = TargetOfBlock(frame.target, shown.layers, Read(block, view), exposure);
      return shown;
    };
    frames.push_back({scene_.camera(view), {}, {}, read});
  }
  return frames;
}

void BlockLayers::RemoveTogether(size_t block, const std::vector<uint32_t>& views) const {
  for (const uint32_t view : views)
    for (const LayerKind kind : {LayerKind::kFront, LayerKind::kBehind})
      files_.RemoveLayer(block, view, kind);
}

}  // namespace cosplat

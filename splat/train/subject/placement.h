// What density control asks of the subject: how Gaussians move, which are close to each other, and
// which must stay.
#pragma once

#include <cstdint>
#include <vector>

#include "splat/gaussians.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// The renderer that density control may use between steps, with the steps' own buffers.
struct Canvas {
  Rasterizer& rasterizer;
  RenderedImage& image;
  RenderTape& tape;
};

// How density control moves and locates Gaussians: a static scene moves a point, an avatar
// re-embeds it on its mesh. Arrays are in the stream's memory.
class Placement {
 public:
  virtual ~Placement() = default;
  // Applies the same reordering to per-Gaussian data outside `Gaussians`.
  virtual void Gather(View<const uint32_t> /*source*/, Stream& /*stream*/) {}
  // Moves each Gaussian from `first` on by one row of `offsets` ([rows, 3]), in the frame that
  // kRotation and kScaleLog refer to.
  virtual void Move(View<const float> offsets, size_t first, Gaussians& gaussians, Stream& stream);
  // [N, 3] positions in a coordinate frame where Gaussians that are close are close in every
  // training frame. Valid until the next call.
  virtual View<const float> Centers(const Gaussians& gaussians, Stream& /*stream*/) {
    return gaussians.values[kPosition].view();
  }
  // Group of each Gaussian for pruning, on the host; empty: a single group. Waits for the stream.
  virtual std::vector<int32_t> Groups(Stream& /*stream*/) { return {}; }
  // May veto removals (that would tear holes into an avatar): resets the flags in `unwanted`
  // ([N], 1: remove) of Gaussians that must stay. canvas: null if nothing can be rendered.
  virtual void Veto(const Gaussians& /*gaussians*/,
                    const Canvas* /*canvas*/,
                    View<uint8_t> /*unwanted*/,
                    Stream& /*stream*/) {}
};

}  // namespace cosplat

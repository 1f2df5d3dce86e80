// What other blocks of a scene show in a view while one block is trained: the part of the image in
// front of the block and the part behind it, rendered before (splat/train/blocks/blocks.h).
//
// The blocks are convex and disjoint, so that a camera sees one wholly in front of another, and a
// view is  front + (1 - alpha of front) (block + transmittance of the block * behind).  As bytes,
// layers are exact to 1/510 of a channel, which 59 dB of PSNR hide.
#pragma once

#include <array>
#include <vector>

#include "splat/base/image.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

// RGBA with colours multiplied by alpha, of the frame's size; empty: there is nothing.
struct FrameLayers {
  Image8 front, behind;
  bool empty() const { return front.empty() && behind.empty(); }
};

// A rendered image, over black, as a layer; empty if nothing of it is visible.
Image8 LayerOf(const RenderedImage& rendered);

// Layers of one size, put together front to back.
class LayerStack {
 public:
  // Adds one behind those that there are; returns the share of the image that it covers: its alpha
  // times what is left by those in front of it, mean over the pixels.
  float Add(const Image8& layer);
  // All of them as one; empty if there are none.
  Image8 Together() const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<std::array<float, 4>> pixels_;  // colour, transmittance
};

// Between a block's rendered image and the whole view, in a stream's memory. On the host only.
class LayerModel {
 public:
  // Puts the layer behind, over the background, behind an image rendered over black, in place: the
  // colour that the renderer's backward pass expects.
  void AddBehind(const FrameLayers& layers,
                 const std::array<float, 3>& background,
                 RenderedImage& image,
                 Stream& stream);
  // That image with the layer in front. Valid until the next call.
  const Buffer<float>& Forward(const FrameLayers& layers, View<const float> color, Stream& stream);
  // Turns the gradient of what Forward returned into that of its argument, in place.
  void Backward(const FrameLayers& layers, Buffer<float>& d_shown, Stream& stream);
  size_t allocated_bytes() const { return AllocatedBytes(shown_); }

 private:
  Buffer<float> shown_;
};

}  // namespace cosplat

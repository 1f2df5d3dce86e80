#include "splat/train/blocks/layers.h"

#include <algorithm>

#include "splat/device/for_each.h"
#include "splat/render/kernels/pixel_bytes.h"
#include "splat/train/blocks/kernels/layers.h"

namespace cosplat {
namespace {

const uint8_t* BytesOf(const Image8& layer) { return layer.empty() ? nullptr : layer.data.data(); }

}  // namespace

Image8 LayerOf(const RenderedImage& rendered) {
  Image8 layer(rendered.width, rendered.height, 4);
  const size_t plane = layer.pixels();
  ParallelFor(plane, [&](size_t i) {
    uint8_t* p = &layer.data[4 * i];
    for (size_t c = 0; c < 3; ++c) p[c] = math::ToByte(rendered.color[c * plane + i]);
    p[3] = math::ToByte(1 - rendered.transmittance[i]);
  });
  const bool visible =
      std::any_of(layer.data.begin(), layer.data.end(), [](uint8_t byte) { return byte != 0; });
  return visible ? layer : Image8();
}

float LayerStack::Add(const Image8& layer) {
  if (layer.empty()) return 0;
  if (pixels_.empty()) pixels_.resize(layer.pixels(), {0, 0, 0, 1});
  width_ = layer.width;
  height_ = layer.height;
  double covered = 0;
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const uint8_t* p = &layer.data[4 * i];
    if (p[0] == 0 && p[1] == 0 && p[2] == 0 && p[3] == 0) continue;
    auto& [r, g, b, transmittance] = pixels_[i];
    r += transmittance * math::FromByte(p[0]);
    g += transmittance * math::FromByte(p[1]);
    b += transmittance * math::FromByte(p[2]);
    const float share = transmittance * math::FromByte(p[3]);
    covered += double(share);
    transmittance -= share;
  }
  return float(covered / double(pixels_.size()));
}

Image8 LayerStack::Together() const {
  Image8 all;
  if (pixels_.empty()) return all;
  all = Image8(width_, height_, 4);
  for (size_t i = 0; i < pixels_.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) all.data[4 * i + c] = math::ToByte(pixels_[i][c]);
    all.data[4 * i + 3] = math::ToByte(1 - pixels_[i][3]);
  }
  return all;
}

void LayerModel::AddBehind(const FrameLayers& layers,
                           const std::array<float, 3>& background,
                           RenderedImage& image,
                           Stream& stream) {
  ForEach(image.transmittance.size(),
          stream,
          PutBehind{BytesOf(layers.behind),
                    {background[0], background[1], background[2]},
                    std::as_const(image.transmittance).view(),
                    image.color.view()});
}

const Buffer<float>& LayerModel::Forward(const FrameLayers& layers,
                                         View<const float> color,
                                         Stream& stream) {
  shown_.Refill(color.count, stream);
  ForEach(color.count / 3, stream, PutInFront{BytesOf(layers.front), color, shown_.view()});
  return shown_;
}

void LayerModel::Backward(const FrameLayers& layers, Buffer<float>& d_shown, Stream& stream) {
  if (layers.front.empty()) return;
  ForEach(d_shown.size() / 3, stream, PutInFrontVjp{BytesOf(layers.front), d_shown.view()});
}

}  // namespace cosplat

// Part of an image, copied out of it and added to it.
#pragma once

#include "splat/device/buffer.h"
#include "splat/train/loss/crop_loss.h"

namespace cosplat {

// Where number i of a crop's planes [3, crop height, crop width] is in an image's.
struct CropPlaces {
  Crop crop;
  int width, height;  // px, of the image
  COSPLAT_HD size_t At(size_t i) const {
    const size_t x = i % size_t(crop.width), row = i / size_t(crop.width);
    const size_t y = row % size_t(crop.height), channel = row / size_t(crop.height);
    return (channel * size_t(height) + y + size_t(crop.y)) * size_t(width) + x + size_t(crop.x);
  }
};

struct CopyCrop {
  CropPlaces places;
  View<const float> image;
  View<float> crop;
  COSPLAT_HD void operator()(size_t i) const { crop[i] = image[places.At(i)]; }
};

struct AddCrop {
  CropPlaces places;
  float weight;
  View<const float> crop;
  View<float> image;
  COSPLAT_HD void operator()(size_t i) const { image[places.At(i)] += weight * crop[i]; }
};

}  // namespace cosplat

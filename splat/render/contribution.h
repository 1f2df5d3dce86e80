// What one Gaussian does for one image, summed over its pixels.
#pragma once

#include "splat/math/namespace.h"

namespace cosplat {

// With alpha and T (the transmittance before it) at a pixel, and Delta the change of the pixel's
// colour when this Gaussian alone is taken out (math/blend.h, LossWithout):
struct Contribution {
  float weight;       // sum of alpha T: its share of the image, px
  float hits;         // sum of opacity T over the pixels that it reaches (LightGaussian's score)
  float sensitivity;  // sum of (d(red + green + blue)/d(falloff))^2 (Speedy-Splat's score)
  float change;       // sum of |Delta|^2 over the channels

  COSPLAT_HD Contribution& operator+=(const Contribution& other) {
    weight += other.weight;
    hits += other.hits;
    sensitivity += other.sensitivity;
    change += other.change;
    return *this;
  }
};

}  // namespace cosplat

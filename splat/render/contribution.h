// What one Gaussian contributes to one image, summed over the image's pixels.
#pragma once

#include "splat/math/namespace.h"

namespace cosplat {

// At a pixel, T is the transmittance in front of this Gaussian, alpha its alpha, and Delta the
// change in the pixel's colour when this Gaussian alone is removed (LossWithout in
// splat/math/blend.h).
struct Contribution {
  float weight;       // sum of alpha T: its share of the image, in px
  float hits;         // sum of opacity T over the pixels that it reaches (LightGaussian's score)
  float sensitivity;  // sum of (d(red + green + blue)/d(falloff))^2 (Speedy-Splat's score)
  float change;       // sum of |Delta|^2, the squared norm over the three channels

  COSPLAT_HD Contribution& operator+=(const Contribution& other) {
    weight += other.weight;
    hits += other.hits;
    sensitivity += other.sensitivity;
    change += other.change;
    return *this;
  }
};

}  // namespace cosplat

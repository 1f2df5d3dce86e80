// Z-buffer for the opaque surfaces that the viewer draws itself: the nearest colour per sample,
// four samples per pixel.
//
// mesh_view.h, ellipsoid_view.h -> SurfaceBuffer -> Resolve -> image.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"

namespace cosplat::viewer {

using Rgb = std::array<uint8_t, 3>;

constexpr int kSamplesPerSide = 2;

struct SurfaceBuffer {
  int width = 0;             // samples
  int height = 0;            // samples
  std::vector<float> depth;  // [height, width], world units along the camera's axis; infinity: none
  std::vector<Rgb> color;    // [height, width]

  // Clears the buffer for an image of this size; keeps its memory.
  void Clear(int image_width, int image_height);
  void Put(int x, int y, float z, const Rgb& rgb) {
    const size_t i = size_t(y) * size_t(width) + size_t(x);
    if (!(z < depth[i])) return;
    depth[i] = z;
    color[i] = rgb;
  }
};

// A camera whose pixels are the buffer's samples.
Camera SampleCamera(const Camera& camera);

// Calls draw(first_row, end_row) for disjoint bands of rows in parallel. Each sample belongs to one
// band, so the result does not depend on the number of threads.
void ForBands(const SurfaceBuffer& buffer, const std::function<void(int, int)>& draw);

// RGBA, straight alpha: over `background` with alpha 255 everywhere, or transparent if it is null.
void Resolve(const SurfaceBuffer& buffer, const std::array<float, 3>* background, Image8& out);

// Shades `rgb` by a lamp next to the camera. normal: unit length, in the camera's axes, of either
// sign.
Rgb Lit(const Rgb& rgb, const std::array<float, 3>& normal);

// Colours for counts, shared by the image and its legend.

// From dark blue over green to yellow, in even steps of brightness. t: [0, 1], clamped.
Rgb ScaleColor(float t);

// Position of a count on a scale from 0 to `max`, in [0, 1]: logarithmic, since counts per
// triangle span decades.
float CountPlace(int count, int max);

// Triangles without any Gaussian.
constexpr Rgb kNoneColor{70, 70, 74};

}  // namespace cosplat::viewer

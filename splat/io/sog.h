// Splats as SOG (PlayCanvas, version 2), about a fifteenth of a PLY: lossless WebP images in which
// a pixel is a splat, and meta.json with ranges and codebooks.
//
// Positions: sign(x) log(1 + |x|), 16 bits per axis between the bounds, in two images. Scales and
// constant colours: a byte each that points into a codebook of 256 numbers. Rotations: the smallest
// three components in a byte each, and which is the largest. Opacities: a byte. Bands 1 and up: 16
// bits that point into a palette of at most 65,536 colours, whose numbers point into a codebook of
// 256 themselves. Splats are in Morton order, which is what the images deflate by.
//
// Codebooks and palette come from k-means (splat/io/kmeans.h) weighted by significance. Axes are
// those of the PLY, as PlayCanvas' own tools write them (its text says y up; docs/files.md).
// Source: developer.playcanvas.com, "The SOG Format".
#pragma once

#include <string>
#include <vector>

#include "splat/gaussians.h"

namespace cosplat {

struct SogSettings {
  std::vector<float> seen_bands;  // of SeenBands (splat/io/color_weights.h), or empty
  int palette = 16384;            // colours of bands 1 and up, at most: 1 to 65536
  uint64_t seed = 0;
};

// `path`: a bundle (a zip), or, if it ends in meta.json, that file with the images beside it.
// gaussians: in 3DGS's SH, of degree at most 3. significance: [N] >= 0, what an error of each
// Gaussian's colour weighs; non-finite values count as 0. The same arguments give the same bytes
// for any number of threads. A bundle is atomic; of a folder meta.json is written last. Throws
// Error if the basis or the degree is another, if a value is not finite, and if there are no
// Gaussians or more than an image of 16383 x 16383 holds.
void WriteSog(const std::string& path,
              const Gaussians& gaussians,
              View<const float> significance,
              const SogSettings& settings);

// `path`: a bundle, a meta.json, or a folder that has one. In 3DGS's SH. Throws Error naming file,
// image or field for another version, for more splats than the file can hold, for an image that is
// missing, damaged, lossy or too small, and for an index beyond its codebook.
Gaussians ReadSog(const std::string& path);

// A zip with a meta.json, a file of that name, or a folder that has one. False if there is nothing.
bool IsSog(const std::string& path);

}  // namespace cosplat

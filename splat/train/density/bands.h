// Removes imperceptible colour bands: found by their energy, zeroed and no longer evaluated.
//
// trained Gaussians -> DropBands -> Gaussians::degrees -> kernels evaluate each Gaussian up to its
// own degree. docs/dcsh.md derives the energy and reports measurements.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "splat/gaussians.h"
#include "splat/train/prune/importance.h"

namespace cosplat {

// Root mean square of a band's part of the colour over all directions and channels; 1 is the range
// of the colours. Works for any basis. 1 <= band <= gaussians.degree.
float BandEnergy(const Gaussians& gaussians, size_t i, int band);

// [N] weight of each Gaussian in a set of images: the sum of alpha T over their pixels.
using Weights = std::vector<float>;

// Zeroes the highest bands of Gaussians and sets `degrees`. As predicted from the bands' energies,
// the images change by at most `threshold` (1 is the range of the colours), root mean square over
// the area that the Gaussians cover; the bands that change the images least per coefficient are
// removed. Gaussians that are in no image lose all bands; bands with non-finite coefficients are
// kept. Removed bands are never restored.
void DropBands(const Weights& weights, float threshold, Gaussians& gaussians);

// Zeroes the coefficients above each Gaussian's own degree, also in arrays laid out like Gaussians.
void ZeroAbove(View<const uint8_t> degrees, Gaussians& of);

// Number of Gaussians of each degree.
using DegreeCounts = std::array<size_t, kMaxTrainedDegree + 1>;
DegreeCounts CountDegrees(const Gaussians& gaussians);

struct DegreeFigures {
  double mean = 0;        // of the Gaussians' own degrees
  double rest_saved = 0;  // share of the coefficients of bands >= 1 that are not needed
};
DegreeFigures FiguresOf(const DegreeCounts& counts, int degree);

// Training drops bands in `kRounds` rounds, spread evenly over its last third, the last one at its
// end. In between, the remaining parameters settle.
struct BandSchedule {
  static constexpr int kRounds = 4;

  // Iterations count from 1.
  static bool DropsAt(int iteration, int iterations);
};

// Performs one such round, with weights from training images (of `frames`) over `background`.
// Dropped coefficients stay zero since they get neither momentum nor gradients: their moments are
// the caller's to zero (ZeroAbove). Adam must have caught up (splat/train/optimize/optimizer.h).
// threshold: for all rounds together. `changed` is called after the bands are dropped and before
// `images` is queried again. Returns the change in dB of the mean PSNR of up to 20 training images.
double DropBandsInTraining(float threshold,
                           FrameImages& images,
                           View<const uint32_t> frames,
                           const std::array<float, 3>& background,
                           Gaussians& gaussians,
                           const std::function<void()>& changed);

}  // namespace cosplat

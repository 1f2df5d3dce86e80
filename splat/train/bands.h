// Bands of colour that nobody can see: found by their energy, dropped, not evaluated again.
//
// trained Gaussians -> DropBands -> Gaussians::degrees -> kernels evaluate each Gaussian to its own
// degree; splat/io/vq_file.h stores it so. docs/dcsh.md derives the energy and has what was
// measured.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "splat/gaussians.h"
#include "splat/train/importance.h"

namespace cosplat {

// Root mean square of band l's part of the colour, over all directions and channels; 1 is the range
// of the colours. In any basis. 1 <= band <= gaussians.degree.
float BandEnergy(const Gaussians& gaussians, size_t i, int band);

// How much of some images each Gaussian is: [N] sums over their pixels of alpha T, its weight.
using Weights = std::vector<float>;

// Zeroes the highest bands of Gaussians and sets `degrees`. The images change by `threshold` (1
// is the range of the colours), root mean square over what the Gaussians cover, or a little less,
// as their energies tell; what goes is what changes them least for each of its coefficients. What
// is in no image keeps none; bands with numbers that are not finite stay. None comes back.
void DropBands(const Weights& weights, float threshold, Gaussians& gaussians);

// Sets what is above each Gaussian's own degree to zero: colours, or what is laid out as they are.
void ZeroAbove(View<const uint8_t> degrees, Gaussians& of);

// How many Gaussians have which degree.
using DegreeCounts = std::array<size_t, kMaxTrainedDegree + 1>;
DegreeCounts CountDegrees(const Gaussians& gaussians);

struct DegreeFigures {
  double mean = 0;        // of the Gaussians' own degrees
  double rest_saved = 0;  // share of the coefficients of bands 1.. that are not needed
};
DegreeFigures FiguresOf(const DegreeCounts& counts, int degree);

// When training drops bands: `kRounds` times, evenly over the last third of it, the last of them at
// its end. In between, what is left settles.
struct BandSchedule {
  static constexpr int kRounds = 4;

  // Iterations count from 1.
  static bool DropsAt(int iteration, int iterations);
};

// A round of it, with the weights of training images (of `frames`) over `background`. Without
// momentum and gradient, what was dropped stays zero. Adam must have caught up
// (splat/train/optimizer.h). threshold: of all rounds together. `changed` is called when they are
// gone, before `images` are asked again. Returns by how many dB the mean PSNR of up to 20
// training images changes.
double DropBandsInTraining(float threshold,
                           FrameImages& images,
                           View<const uint32_t> frames,
                           const std::array<float, 3>& background,
                           Gaussians& gaussians,
                           AdamState& adam,
                           const std::function<void()>& changed);

}  // namespace cosplat

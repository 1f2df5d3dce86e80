// How much each Gaussian matters to a set of pictures: what pruners rank by and what compression
// keeps exact. One pass per picture over what the forward pass drew; sums are exact for the picture
// as it is, with no gradient involved.
#pragma once

#include <array>
#include <vector>

#include "splat/base/camera.h"
#include "splat/contribution.h"
#include "splat/gaussians.h"
#include "splat/subject.h"

namespace cosplat {

// Sums over these frames, at most `most_frames` of them evenly spread, of every Gaussian's
// contribution to the frame's picture over `background`. [N]
std::vector<Contribution> ContributionsToFrames(Subject& subject,
                                                View<const uint32_t> frames,
                                                const Gaussians& gaussians,
                                                int degree,
                                                const std::array<float, 3>& background,
                                                size_t most_frames);

// Mean PSNR of as many of these frames, likewise, pictures clamped to what bytes can show, dB.
double MeanPsnrOfFrames(Subject& subject,
                        View<const uint32_t> frames,
                        const Gaussians& gaussians,
                        int degree,
                        const std::array<float, 3>& background,
                        size_t most_frames);

// LightGaussian's global significance (Fan et al. 2024, eq. 2-4): contribution.hits times
// (V / V_90)^0.1, V the volume of the Gaussian, V_90 that which 90 % of them do not exceed. V is
// not capped. [N]
std::vector<float> Significance(const Gaussians& gaussians,
                                const std::vector<Contribution>& contributions);

// The same over the pictures of a static scene's cameras, on black.
std::vector<float> GlobalSignificance(const Gaussians& gaussians,
                                      const std::vector<Camera>& cameras);

}  // namespace cosplat

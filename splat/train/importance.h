// How much each Gaussian matters to a set of images: what pruners rank by and what compression
// keeps exact. One pass per image over what the forward pass drew; sums are exact for the image
// as it is, with no gradient involved.
#pragma once

#include <array>
#include <vector>

#include "splat/base/camera.h"
#include "splat/gaussians.h"
#include "splat/render/contribution.h"
#include "splat/train/subject.h"

namespace cosplat {

// Images to ask, drawn over `background`: of these frames, at most `most_frames` evenly spread.
struct FrameChoice {
  View<const uint32_t> frames;
  int degree = 0;
  std::array<float, 3> background{0, 0, 0};
  size_t most_frames = 0;

  size_t count() const { return frames.size() < most_frames ? frames.size() : most_frames; }
  size_t operator[](size_t k) const { return frames[k * frames.size() / count()]; }
};

// Mean PSNR of these frames, images clamped to what bytes can show, dB. Everything is in the
// memory of the rasteriser's stream.
double MeanPsnrOfFrames(Subject& subject,
                        const Gaussians& gaussians,
                        const FrameChoice& choice,
                        Rasterizer& rasterizer,
                        RenderTape& tape);

// What pruners ask about Gaussians in training: sums over these frames of every Gaussian's
// contribution to the frame's image, [N]; and MeanPsnrOfFrames.
class FrameImages {
 public:
  virtual ~FrameImages() = default;
  virtual std::vector<Contribution> Contributions(const FrameChoice& choice) = 0;
  virtual double MeanPsnr(const FrameChoice& choice) = 0;
};

// LightGaussian's global significance (Fan et al. 2024, eq. 2-4): contribution.hits times
// (V / V_90)^0.1, V the volume of the Gaussian, V_90 that which 90 % of them do not exceed. V is
// not capped. [N]
std::vector<float> Significance(const Gaussians& gaussians,
                                const std::vector<Contribution>& contributions);

// The same over the images of a static scene's cameras, on black.
std::vector<float> GlobalSignificance(const Gaussians& gaussians,
                                      const std::vector<Camera>& cameras);

}  // namespace cosplat

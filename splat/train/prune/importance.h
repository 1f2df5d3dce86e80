// How much each Gaussian matters to a set of images: pruners rank by it, and compression keeps the
// most important Gaussians exact. One pass per image over what the forward pass rendered; sums are
// exact for the image as it is and need no gradient.
#pragma once

#include <array>
#include <vector>

#include "splat/base/camera.h"
#include "splat/gaussians.h"
#include "splat/render/contribution.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

// Images to evaluate, rendered over `background`: up to `max_frames` of these frames, evenly
// spread.
struct FrameChoice {
  View<const uint32_t> frames;
  int degree = 0;
  std::array<float, 3> background{0, 0, 0};
  size_t max_frames = 0;
  // Contributions: images are drawn larger by this share of their size on every side, since what
  // lies just beyond them is seen from the side (WithMargin).
  float margin = 0;

  size_t count() const { return frames.size() < max_frames ? frames.size() : max_frames; }
  size_t operator[](size_t k) const { return frames[k * frames.size() / count()]; }
};

// How far images are from those of the frames, where these are not ignored.
struct ImageError {
  double mean_psnr = 0;  // dB, mean over the images; 0 without any
  double squared = 0;    // sum over images, pixels and channels
};

// Of these frames, with images clamped to [0, 1]. fits_exposure: brings each image to its frame's
// exposure first (FitExposure). Everything is in the memory of the rasteriser's stream.
ImageError ErrorOfFrames(Subject& subject,
                         const Gaussians& gaussians,
                         const FrameChoice& choice,
                         bool fits_exposure,
                         Rasterizer& rasterizer,
                         RenderTape& tape);

// What pruners can query about Gaussians in training: every Gaussian's contribution, summed over
// the images of these frames, [N]; and ErrorOfFrames, of all Gaussians or without some ([N], 1:
// without it).
class FrameImages {
 public:
  virtual ~FrameImages() = default;
  virtual std::vector<Contribution> Contributions(const FrameChoice& choice) = 0;
  virtual ImageError ErrorIn(const FrameChoice& choice) = 0;
  virtual ImageError ErrorWithout(View<const uint8_t> removed, const FrameChoice& choice) = 0;
};

// The same camera with a larger image: by this share of width and height on every side.
Camera WithMargin(Camera camera, float share);

// Makes these ([N], 1) Gaussians invisible.
void Hide(View<const uint8_t> removed, Gaussians& gaussians);

// LightGaussian's global significance (Fan et al. 2024, eq. 2-4): contribution.hits times
// (V / V_90)^0.1, where V is the volume of the Gaussian and V_90 the 90th percentile of the
// volumes. V is not capped. [N]
std::vector<float> Significance(const Gaussians& gaussians,
                                const std::vector<Contribution>& contributions);

// The same for images rendered over black from the cameras of a static scene.
std::vector<float> GlobalSignificance(const Gaussians& gaussians,
                                      const std::vector<Camera>& cameras);

}  // namespace cosplat

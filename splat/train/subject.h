// What is trained: where its Gaussians are in each frame, and the frames. Static scenes:
// splat/train/trainer.h; avatars: avatar/train/trainer.h.
#pragma once

#include <any>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/gaussians.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/density.h"
#include "splat/train/optimizer.h"

namespace cosplat {

// One training frame.
struct TrainFrame {
  Camera camera;
  Image8 target;  // RGB or straight-alpha RGBA, of the camera's size
};

class Subject : public Placement {
 public:
  virtual size_t frame_count() const = 0;
  virtual const TrainFrame& frame(size_t i) const = 0;
  // World units per unit of position rate: the scene's extent, or 1.
  virtual float extent() const = 0;
  // The Gaussians in the world of frame i. Borrowed until the next call.
  virtual WorldGaussians Place(const Gaussians& gaussians, size_t i) = 0;
  // Where, and of which, the rasteriser shall write its gradients for Place's result.
  virtual WorldGradients WorldGradientsFor(Gaussians& gradients, Buffer<float>& screen) = 0;
  // Turns what was written there into gradients of `gaussians`, in place.
  virtual void PlaceBackward(const Gaussians& gaussians, Gaussians& gradients) {
    (void)gaussians;
    (void)gradients;
  }
  // [N, 3] factors on the rate of kPosition's components, where they differ in unit; or empty.
  virtual View<const float> PositionRateScale() { return {}; }
  // Its own state, to go back to (splat/train/budget.h); none for a subject that has none.
  virtual std::any SaveState() const { return {}; }
  virtual void RestoreState(const std::any& state) { (void)state; }
  // After the step's update; `iteration` counts from 1.
  virtual void AfterStep(int iteration, Gaussians& gaussians, AdamState& adam) {
    (void)iteration;
    (void)gaussians;
    (void)adam;
  }
};

}  // namespace cosplat

// What is trained: where its Gaussians are in each frame, and the frames. Static scenes:
// splat/train/scene_subject.h; avatars: avatar/train/trainer.h.
#pragma once

#include <memory>
#include <vector>

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

// What a subject is at a moment beside the Gaussians: a subject's own (AvatarTrainingState).
struct SubjectState {
  virtual ~SubjectState() = default;
};

// Gaussians, gradients and everything borrowed are in the memory of the stream that it works in.
class Subject : public Placement {
 public:
  virtual size_t frame_count() const = 0;
  virtual const TrainFrame& frame(size_t i) const = 0;
  // World units per unit of position rate: the scene's extent, or 1.
  virtual float extent() const = 0;

  // Takes what it has of its own there: where the following calls work. At first, the host's.
  // Throws Error where it is nothing for a device.
  virtual void WorkIn(Stream& stream) { (void)stream; }
  // The Gaussians in the world of frame i. Borrowed until the next call.
  virtual WorldGaussians Place(const Gaussians& gaussians, size_t i) = 0;
  // Where, and of which, the rasteriser shall write its gradients for Place's result.
  virtual WorldGradients WorldGradientsFor(Gaussians& gradients,
                                           Buffer<float>& screen,
                                           Stream& stream) = 0;
  // Turns what was written there into gradients of `gaussians`, in place.
  virtual void PlaceBackward(const Gaussians& gaussians, Gaussians& gradients) {
    (void)gaussians;
    (void)gradients;
  }
  // Whether PlaceBackward waits for its result and changes what is not the stream's: a step must
  // then be right the first time.
  virtual bool WaitsInSteps() const { return false; }
  // [N, 3] factors on the rate of kPosition's components, where they differ in unit; or empty.
  virtual View<const float> PositionRateScale() { return {}; }
  // What it does to the Gaussians after the step's update, where it does anything: `iteration`
  // counts from 1.
  virtual bool ActsAfter(int iteration) const {
    (void)iteration;
    return false;
  }
  virtual void Act(int iteration, Gaussians& gaussians, AdamState& adam) {
    (void)iteration;
    (void)gaussians;
    (void)adam;
  }

  // Its own state, to go back to (splat/train/budget.h); null for a subject that has none.
  virtual std::shared_ptr<const SubjectState> SaveState() const { return nullptr; }
  virtual void RestoreState(const SubjectState& state) { (void)state; }

  // What it holds in a device's memory, and what each Gaussian takes of that.
  virtual std::vector<MemoryPart> Memory() const { return {}; }
  virtual size_t BytesPerGaussian() const { return 0; }
};

}  // namespace cosplat

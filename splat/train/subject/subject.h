// What is trained: its frames, and where its Gaussians are in each of them. Static scenes:
// splat/train/subject/scene_subject.h; avatars: avatar/train/avatar_subject.h.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/base/state_file.h"
#include "splat/gaussians.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/blocks/layers.h"
#include "splat/train/optimize/optimizer.h"
#include "splat/train/subject/placement.h"

namespace cosplat {

// One training frame.
struct TrainFrame {
  Camera camera;
  Image8 target;  // RGB or straight-alpha RGBA, of the camera's size
  // Empty, or one channel of that size: not 0 where the target is to be ignored.
  Image8 ignored = {};
  // Reads the images of a frame that is not kept in memory, which are empty here
  // (frame_reader.h). Throws Error.
  std::function<TrainFrame()> read = {};
  // What else is to be seen besides the Gaussians that are trained; not in reduced copies.
  FrameLayers layers = {};
};

// A subject's state besides the Gaussians; each subject defines its own (AvatarTrainingState).
struct SubjectState {
  virtual ~SubjectState() = default;
  // Writes it to a checkpoint or reads it. count: number of Gaussians. Throws Error when what is
  // read does not fit together; what it refers to (frames, triangles) RestoreState checks.
  virtual void Serialize(StateArchive& archive, size_t count) = 0;
};

// Gaussians, gradients and all borrowed arrays are in the memory of the stream that it works in.
class Subject : public Placement {
 public:
  virtual size_t frame_count() const = 0;
  // Valid until the next call.
  virtual const TrainFrame& frame(size_t i) const = 0;
  virtual const Camera& camera(size_t i) const { return frame(i).camera; }
  // Whether frame i is a guess, not what a camera saw: it is trained on in passes after density
  // control alone, and has less to say about sizes and opacities. False of some frame.
  virtual bool IsGuess(size_t /*i*/) const { return false; }
  // That `frame(i)` will be called soon.
  virtual void Expect(size_t i) { (void)i; }
  // Maximum bytes of the reduced copies of images that are kept.
  virtual size_t max_reduced_bytes() const { return size_t(-1); }
  // World units per unit of position learning rate: the scene's extent, or 1.
  virtual float extent() const = 0;

  // Moves the subject's own data to the stream in which the following calls work; at first, the
  // host's. Throws Error if the subject does not support a device.
  virtual void WorkIn(Stream& stream) { (void)stream; }
  // Whether kPosition is a point in the world, the same in every frame.
  virtual bool is_static() const { return false; }
  // The Gaussians in the world of frame i. Valid until the next call.
  virtual WorldGaussians ToWorld(const Gaussians& gaussians, size_t i) = 0;
  // Which gradients of ToWorld's result the rasteriser has to write, and where.
  virtual WorldGradients WorldGradientsFor(Gaussians& gradients,
                                           Buffer<float>& screen,
                                           Stream& stream) = 0;
  // Backward pass of ToWorld: turns what was written there into gradients of `gaussians`, in place.
  // If *overflowed is not 0 the step will be repeated: the subject must not change.
  virtual void ToWorldBackward(const Gaussians& /*gaussians*/,
                               Gaussians& /*gradients*/,
                               const uint32_t* /*overflowed*/) {}
  // Whether ToWorldBackward waits for its result and changes data outside the stream: such a step
  // cannot be repeated, so it must not overflow.
  virtual bool WaitsInSteps() const { return false; }
  // [N, 3] factors on the learning rate of kPosition's components, if they differ in unit; else
  // empty.
  virtual View<const float> PositionRateScale() { return {}; }
  // Whether the subject changes the Gaussians after the step's update, and how. `iteration` counts
  // from 1.
  virtual bool ChangesAfter(int /*iteration*/) const { return false; }
  virtual void Change(int /*iteration*/, Gaussians& /*gaussians*/, AdamState& /*adam*/) {}

  // Saves and restores the subject's own state; null if it has none. RestoreState throws Error if
  // the state is not of this subject.
  virtual std::shared_ptr<SubjectState> SaveState() const { return nullptr; }
  virtual void RestoreState(const SubjectState& state) { (void)state; }

  // What it holds in a device's memory, and bytes of that per Gaussian.
  virtual std::vector<MemoryPart> Memory() const { return {}; }
  virtual size_t BytesPerGaussian() const { return 0; }
};

}  // namespace cosplat

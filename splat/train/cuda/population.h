// All that is per Gaussian of a training run, on the device: Population (splat/train/density.h)
// there.
#pragma once

#include <array>

#include "splat/train/cuda/adam.h"
#include "splat/train/cuda/mask_learner.h"
#include "splat/train/step_engine.h"

namespace cosplat::cuda {

// DensityStatistics there.
struct Statistics {
  DeviceBuffer<float> screen_gradient, plasticity, visible;  // [N]

  std::array<DeviceBuffer<float>*, 3> all() { return {&screen_gradient, &plasticity, &visible}; }
  void Reset(size_t n, cudaStream_t stream);
  void Upload(const DensityStatistics& from, cudaStream_t stream);
  // They are there when the stream has been waited for.
  void Download(DensityStatistics& to, cudaStream_t stream);
};

class Population {
 public:
  size_t size() const { return values.size(); }
  void Upload(const TrainingState& state, cudaStream_t stream);
  // The host waits.
  void Download(TrainingState& state, cudaStream_t stream);
  // Without moments and coefficients of bands 1.., which are most of it.
  void DownloadForRanking(TrainingState& state, cudaStream_t stream);

  // Entry i becomes what source[i] was; from first_fresh on they are new: their moments and
  // statistics are zero. Adam must have caught up. Leaves any values in `gradients`, whose memory
  // this takes turns with.
  void Gather(DeviceView<const uint32_t> source, size_t first_fresh, cudaStream_t stream);

  // Steps change nothing while `overflowed` is not 0: the step overflows when it finds that a step
  // cannot be right. This lets them go on, as Upload does.
  void GoOn(cudaStream_t stream) { overflowed.FillWithZeros(stream); }

  std::vector<MemoryPart> Memory() const;

  DeviceGaussians values, gradients;
  Adam adam;
  Statistics statistics;
  MaskLearner mask;
  DeviceBuffer<uint32_t> overflowed;  // [1]

 private:
  DeviceBuffer<float> spare_;
  DeviceBuffer<uint8_t> spare_degrees_;
  size_t ignored_before_ = 0;  // gradients that the uploaded state had ignored
};

}  // namespace cosplat::cuda

// The smaller parts of a training step on the device: what density control gathers, the regulariser
// of scales, sums of contributions.
#pragma once

#include "splat/train/cuda/population.h"

namespace cosplat::cuda {

// As DensityStatistics::Accumulate; nothing while the population is overflowed. screen: [N, 2].
void Accumulate(DeviceView<const float> radii,
                DeviceView<const float> screen,
                int width,
                int height,
                Population& population,
                cudaStream_t stream);

// sums[i] += of_picture[i].
void AddContributions(DeviceView<const Contribution> of_picture,
                      DeviceView<Contribution> sums,
                      cudaStream_t stream);

struct NeedleTotal {
  double value;  // of the loss
  float scale;   // weight / how many
};

// ScaleRegularizer (splat/train/train_settings.h) on the device.
class NeedleRegularizer {
 public:
  // Adds to the gradients of those that it regularises, and marks in `moves` ([N]) them and those
  // with a radius: what Adam works on.
  void Add(const ScaleRegularizer& settings,
           DeviceView<const float> radii,
           Population& population,
           cudaStream_t stream);
  DeviceView<const float> moves() const { return moves_.view(); }
  // [1] what it adds to the loss, on the device.
  const double* value() const { return &total_.data()->value; }

 private:
  DeviceBuffer<double> sums_, counts_;  // [blocks]
  DeviceBuffer<NeedleTotal> total_;     // [1]
  DeviceBuffer<float> moves_;
};

}  // namespace cosplat::cuda

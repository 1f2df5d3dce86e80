// Density control on the device: splat/train/density.h there.
//
// statistics -> who is cloned or split (CUB counts where each goes) -> gathered -> children moved
// -> who goes -> gathered -> Morton order -> gathered. Random numbers are the host's, by index.
#pragma once

#include "splat/base/rng.h"
#include "splat/device/cuda/sort.h"
#include "splat/train/cuda/device_subject.h"

namespace cosplat::cuda {

class DensityControl {
 public:
  // Keeps references to the placement and to what the canvas has.
  DensityControl(DeviceSubject& placement, const Canvas& canvas)
      : placement_(placement), canvas_(canvas) {}

  // As ControlDensity (splat/train/density.h). Returns whether the limit on their number held some
  // back.
  bool Control(const DensitySettings& settings,
               bool remove_oversized,
               Population& population,
               Rng& rng,
               cudaStream_t stream);
  // What `unwanted` ([N], 1) marks goes.
  void Take(DeviceView<const uint8_t> unwanted, Population& population, cudaStream_t stream);
  // As SortInSpace.
  void SortInSpace(Population& population, cudaStream_t stream);
  size_t held() const;

 private:
  size_t Select(const DensitySettings& settings, const Population& population, cudaStream_t stream);
  void KeepStrongest(size_t room, cudaStream_t stream);
  void Gather(Population& population,
              DeviceView<const uint32_t> source,
              size_t first_fresh,
              cudaStream_t stream);
  void AddChildren(Population& population, Rng& rng, cudaStream_t stream);
  // Turns flags ([n + 1], the last 0) into where each of them goes; returns how many are set.
  size_t PlacesOf(DeviceBuffer<uint64_t>& flags, cudaStream_t stream);

  DeviceSubject& placement_;
  Canvas canvas_;
  DeviceBuffer<float> mean_;    // [N] screen gradients
  DeviceBuffer<uint8_t> kind_;  // [N] Kind (density.cu)
  DeviceBuffer<uint8_t> unwanted_;
  DeviceBuffer<uint64_t> kept_, cloned_, split_;  // [N + 1]
  DeviceBuffer<uint32_t> source_;
  DeviceBuffer<float> offsets_;  // [children, 3]
  KeyedValues order_;
  DeviceBuffer<uint64_t> codes_;
  DeviceBuffer<float> boxes_;  // [blocks, 6]
  Sorter sorter_;
  Readback<uint64_t> readback_;
};

// As ResetOpacity.
void ResetOpacity(Population& population, cudaStream_t stream);

}  // namespace cosplat::cuda

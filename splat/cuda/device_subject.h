// Where the Gaussians are in a frame: Subject (splat/subject.h) on the device.
#pragma once

#include "splat/cuda/device_gaussians.h"

namespace cosplat::cuda {

// This class: a static scene's, which are where they are.
class DeviceSubject {
 public:
  virtual ~DeviceSubject() = default;
  // As Subject's, with pointers of the device. Work goes to the stream.
  virtual WorldGaussians Place(const DeviceGaussians& gaussians,
                               size_t frame,
                               cudaStream_t stream) {
    (void)frame;
    (void)stream;
    return gaussians.View();
  }
  virtual WorldGradients WorldGradientsFor(DeviceGaussians& gradients,
                                           DeviceBuffer<float>& screen) {
    WorldGradients view = gradients.GradientView(screen);
    view.drawn_groups_only = true;  // nothing but Adam reads them
    return view;
  }
  virtual void PlaceBackward(const DeviceGaussians& gaussians,
                             DeviceGaussians& gradients,
                             cudaStream_t stream) {
    (void)gaussians;
    (void)gradients;
    (void)stream;
  }
  // Whether PlaceBackward waits, for what it tells the host's Subject of a step: the step must then
  // be right the first time.
  virtual bool WaitsInSteps() const { return false; }
  virtual const float* PositionRateScale() { return nullptr; }
  // After the host's Subject has changed what it has of its own for each Gaussian, and at first.
  virtual void Changed(cudaStream_t stream) { (void)stream; }
  // Whether the host's Subject has something to do after this step (Subject::AfterStep): all is
  // then copied there and back.
  virtual bool WorksAfter(int iteration) const {
    (void)iteration;
    return false;
  }
  // Whether Gaussians come, go and are reordered by the host's Subject, because it has data of its
  // own for each: all is then copied there and back.
  virtual bool ControlsDensityOnHost() const { return false; }
};

}  // namespace cosplat::cuda

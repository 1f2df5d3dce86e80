// Where the Gaussians are in a frame, and what is per Gaussian beside them: Subject
// (splat/train/subject.h) on the device.
#pragma once

#include <vector>

#include "splat/render/cuda/renderer.h"
#include "splat/train/cuda/population.h"

namespace cosplat::cuda {

// Who draws for density control, between steps, in the memory that steps have anyway.
struct Canvas {
  Renderer& renderer;
  DeviceImage& image;
  Tape& tape;
  Basis basis;
};

// This class: a static scene's, which are where they are. Names that Subject has mean the same
// here, with pointers of the device; work goes to the stream.
class DeviceSubject {
 public:
  virtual ~DeviceSubject() = default;
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
  virtual const float* PositionRateScale(cudaStream_t stream) {
    (void)stream;
    return nullptr;
  }
  // What Subject::AfterStep does; and whether there is anything after this step, since the steps
  // before must then have settled.
  virtual bool WorksAfter(int iteration) const {
    (void)iteration;
    return false;
  }
  virtual void Work(Population& population, cudaStream_t stream) {
    (void)population;
    (void)stream;
  }

  virtual void Gather(DeviceView<const uint32_t> source, cudaStream_t stream) {
    (void)source;
    (void)stream;
  }
  // All from `first` on, by a row of `offsets` ([rows, 3]) each.
  virtual void Move(DeviceView<const float> offsets,
                    size_t first,
                    DeviceGaussians& gaussians,
                    cudaStream_t stream);
  // [N, 3], until the next call.
  virtual DeviceView<const float> Centers(const DeviceGaussians& gaussians, cudaStream_t stream) {
    (void)stream;
    return gaussians.values[kPosition].view();
  }
  // The host waits.
  virtual std::vector<int32_t> Groups(cudaStream_t stream) {
    (void)stream;
    return {};
  }
  // Zeroes those of `unwanted` ([N], 1: goes) that must stay. In the renderer's stream.
  virtual void Veto(const DeviceGaussians& gaussians,
                    const Canvas& canvas,
                    DeviceView<uint8_t> unwanted) {
    (void)gaussians;
    (void)canvas;
    (void)unwanted;
  }

  // Takes over what the host's Subject has of its own for each Gaussian; and the way back, for
  // which the host waits.
  virtual void Store(cudaStream_t stream) { (void)stream; }
  virtual void Fetch(cudaStream_t stream) { (void)stream; }

  // What it holds, and what each Gaussian takes of that.
  virtual std::vector<MemoryPart> Memory() const { return {}; }
  virtual size_t BytesPerGaussian() const { return 0; }
};

}  // namespace cosplat::cuda

// Avatars in training on the device: AvatarSubject (avatar/trainer.h) there.
//
// A frame's posed vertices are kept on the device, up to a limit, or posed and sent each time where
// the track is refined; then dL/d(vertices) comes back, too, and the host waits for it. Walking,
// density control and pruning are the host's: they search and walk over the mesh in double, once in
// some hundred steps, for which everything is copied there and back.
#pragma once

#include "avatar/cuda/device_binding.h"
#include "avatar/cuda/posed_vertices.h"
#include "avatar/trainer.h"
#include "splat/cuda/blend_backward.h"
#include "splat/cuda/device_subject.h"
#include "splat/cuda/stream.h"
#include "splat/step_engine.h"

namespace cosplat::cuda {

class DeviceAvatar : public DeviceSubject {
 public:
  // Keeps a reference to `subject`. vertex_limit: bytes for posed vertices.
  DeviceAvatar(AvatarSubject& subject, size_t vertex_limit);

  WorldGaussians Place(const DeviceGaussians& gaussians,
                       size_t frame,
                       cudaStream_t stream) override;
  WorldGradients WorldGradientsFor(DeviceGaussians& gradients,
                                   DeviceBuffer<float>& screen) override;
  void PlaceBackward(const DeviceGaussians& gaussians,
                     DeviceGaussians& gradients,
                     cudaStream_t stream) override;
  bool WaitsInSteps() const override { return refines_; }
  const float* PositionRateScale() override { return rate_scale_.data(); }
  void Changed(cudaStream_t stream) override;
  bool WorksAfter(int iteration) const override;
  bool ControlsDensityOnHost() const override { return true; }

 private:
  AvatarSubject& subject_;
  bool refines_;
  ColorFrame color_frame_;
  Stream copies_;  // of the mesh
  DeviceSurface surface_;
  PosedVertices vertices_;
  DeviceEmbedding embedding_;
  DeviceBinding binding_;
  DevicePosed posed_, d_posed_;
  DeviceBuffer<float> d_vertices_, rate_scale_;
  std::vector<float> d_vertices_on_host_;
};

// For Trainer, of `subject`, which must outlive it.
StepEngineMaker MakeDeviceAvatarEngine(SumOrder order, AvatarSubject& subject);

}  // namespace cosplat::cuda

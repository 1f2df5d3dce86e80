// Avatars in training on the device: AvatarSubject (avatar/train/trainer.h) there.
//
// A frame's posed vertices are kept on the device, up to a limit, or posed and sent each time where
// the track is refined; then dL/d(vertices) comes back, too, and the host waits for it. Walking and
// density control are done there; the host's Subject knows where the Gaussians are after Fetch.
#pragma once

#include <array>

#include "avatar/surface/cuda/device_walk.h"
#include "avatar/surface/kernels/holes.h"
#include "avatar/train/cuda/device_placement.h"
#include "avatar/train/cuda/hole_guard.h"
#include "avatar/train/cuda/posed_vertices.h"
#include "avatar/train/trainer.h"
#include "splat/device/cuda/stream.h"
#include "splat/train/step_engine.h"

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
  const float* PositionRateScale(cudaStream_t stream) override;
  bool WorksAfter(int iteration) const override;
  void Work(Population& population, cudaStream_t stream) override;

  void Gather(DeviceView<const uint32_t> source, cudaStream_t stream) override;
  void Move(DeviceView<const float> offsets,
            size_t first,
            DeviceGaussians& gaussians,
            cudaStream_t stream) override;
  DeviceView<const float> Centers(const DeviceGaussians& gaussians, cudaStream_t stream) override;
  std::vector<int32_t> Groups(cudaStream_t stream) override;
  void Veto(const DeviceGaussians& gaussians,
            const Canvas& canvas,
            DeviceView<uint8_t> unwanted) override;

  void Store(cudaStream_t stream) override;
  void Fetch(cudaStream_t stream) override;
  std::vector<MemoryPart> Memory() const override;
  size_t BytesPerGaussian() const override;

 private:
  bool IsOurs() const { return subject_.settings().system == AvatarSystem::kCosplat; }
  // Of the mesh in the k-th frame that is searched for holes.
  const DeviceBuffer<uint8_t>& SilhouetteOf(size_t k, cudaStream_t stream);

  AvatarSubject& subject_;
  bool refines_;
  ColorFrame color_frame_;
  Stream copies_;  // of the mesh
  DeviceSurface surface_;
  DeviceMesh mesh_;
  DeviceBuffer<float> face_rates_;  // [F]
  PosedVertices vertices_;
  DeviceEmbedding embedding_;
  DeviceBuffer<int32_t> first_triangle_;
  DeviceBinding binding_;
  DeviceWalk walk_;
  DevicePlacement placement_;
  HoleGuard guard_;
  DevicePosed posed_, d_posed_;
  DeviceBuffer<float> rate_scale_;  // [N, 3]
  bool triangles_changed_ = true;   // since it was made
  DeviceBuffer<float> d_vertices_;
  std::vector<float> d_vertices_on_host_;
  std::array<std::vector<uint8_t>, math::kHoleFrames> silhouettes_;
  std::array<DeviceBuffer<uint8_t>, math::kHoleFrames> sent_silhouettes_;
};

// For Trainer, of `subject`, which must outlive it.
StepEngineMaker MakeDeviceAvatarEngine(SumOrder order, AvatarSubject& subject);

}  // namespace cosplat::cuda

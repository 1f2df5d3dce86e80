#include "avatar/cuda/device_avatar.h"

#include "splat/cuda/device_step_engine.h"

namespace cosplat::cuda {
namespace {

// 8,000 frames of FLAME's vertices.
constexpr size_t kVertexBytes = size_t(480) << 20;

}  // namespace

DeviceAvatar::DeviceAvatar(AvatarSubject& subject, size_t vertex_limit)
    : subject_(subject),
      refines_(subject.settings().refine_track),
      color_frame_(subject.settings().color_frame),
      surface_(subject.surface(), copies_.get()),
      vertices_(
          subject.frame_count(), subject.surface().vertex_count(), refines_ ? 0 : vertex_limit) {
  copies_.Wait();
}

WorldGaussians DeviceAvatar::Place(const DeviceGaussians& gaussians,
                                   size_t frame,
                                   cudaStream_t stream) {
  const auto pose = [&]() -> const std::vector<float>& {
    const std::vector<float>& vertices = subject_.VerticesOf(frame);
    subject_.surface().CheckVertices(vertices);
    return vertices;
  };
  surface_.Pose(vertices_.Of(frame, pose, stream), stream);
  binding_.Bind(gaussians, embedding_, surface_, posed_, stream);
  return posed_.View(gaussians, color_frame_);
}

WorldGradients DeviceAvatar::WorldGradientsFor(DeviceGaussians& gradients,
                                               DeviceBuffer<float>& screen) {
  d_posed_.Refill(gradients.size());
  WorldGradients view = gradients.GradientView(screen);
  view.position = d_posed_.position.data();
  view.rotation = d_posed_.rotation.data();
  view.scale_log = d_posed_.scale_log.data();
  if (color_frame_ == ColorFrame::kSurface)
    view.color_frame = d_posed_.frame.data();
  else
    d_posed_.frame.Refill(0);
  return view;
}

void DeviceAvatar::PlaceBackward(const DeviceGaussians& gaussians,
                                 DeviceGaussians& gradients,
                                 cudaStream_t stream) {
  binding_.Backward(gaussians,
                    embedding_,
                    surface_,
                    d_posed_,
                    gradients,
                    refines_ ? &d_vertices_ : nullptr,
                    stream);
  if (!refines_) return;
  d_vertices_on_host_.resize(d_vertices_.size());
  d_vertices_.Download(d_vertices_on_host_.data(), stream);
  Check(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  subject_.RefineFrame(d_vertices_on_host_);
}

void DeviceAvatar::Changed(cudaStream_t stream) {
  embedding_.Upload(subject_.state().embedding, surface_.face_count(), stream);
  const View<const float> scale = subject_.PositionRateScale();
  rate_scale_.Upload(scale.data, scale.size(), stream);
}

bool DeviceAvatar::WorksAfter(int iteration) const {
  return iteration % subject_.settings().walk_every == 0;
}

StepEngineMaker MakeDeviceAvatarEngine(SumOrder order, AvatarSubject& subject) {
  return
      [order, &subject](const TrainSettings& settings, Subject& of_trainer, TrainingState& state) {
        return MakeDeviceStepEngine(order, std::make_shared<DeviceAvatar>(subject, kVertexBytes))(
            settings, of_trainer, state);
      };
}

}  // namespace cosplat::cuda

#include "avatar/train/cuda/device_avatar.h"

#include <algorithm>
#include <utility>

#include "avatar/surface/silhouette.h"
#include "splat/train/cuda/device_step_engine.h"

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
      mesh_(subject.surface(), copies_.get()),
      vertices_(
          subject.frame_count(), subject.surface().vertex_count(), refines_ ? 0 : vertex_limit) {
  face_rates_.Upload(subject.face_rates().data(), subject.face_rates().size(), copies_.get());
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

bool DeviceAvatar::WorksAfter(int iteration) const {
  return iteration % subject_.settings().walk_every == 0;
}

void DeviceAvatar::Work(Population& population, cudaStream_t stream) {
  triangles_changed_ = true;
  walk_.Walk(mesh_, kBoundaryFaceCap, embedding_, population.values.values[kPosition], stream);
  for (DeviceGaussians* moments : {&population.adam.m, &population.adam.v})
    walk_.ResetMoment(moments->values[kPosition], stream);
}

const float* DeviceAvatar::PositionRateScale(cudaStream_t stream) {
  if (std::exchange(triangles_changed_, false))
    placement_.Rates(std::as_const(face_rates_).view(), embedding_, rate_scale_, stream);
  return rate_scale_.data();
}

void DeviceAvatar::Gather(DeviceView<const uint32_t> source, cudaStream_t stream) {
  triangles_changed_ = true;
  embedding_.Gather(source, stream);
  placement_.GatherTriangles(source, first_triangle_, stream);
}

void DeviceAvatar::Move(DeviceView<const float> offsets,
                        size_t first,
                        DeviceGaussians& gaussians,
                        cudaStream_t stream) {
  triangles_changed_ = true;
  placement_.Move(
      mesh_, offsets, first, !IsOurs(), embedding_, gaussians.values[kPosition], stream);
}

DeviceView<const float> DeviceAvatar::Centers(const DeviceGaussians& gaussians,
                                              cudaStream_t stream) {
  return placement_.Centers(mesh_, embedding_, gaussians.values[kPosition], stream);
}

std::vector<int32_t> DeviceAvatar::Groups(cudaStream_t stream) {
  return embedding_.Triangles(stream);
}

const DeviceBuffer<uint8_t>& DeviceAvatar::SilhouetteOf(size_t k, cudaStream_t stream) {
  if (!sent_silhouettes_[k].empty() && !refines_) return sent_silhouettes_[k];
  const size_t frame = math::HoleFrame(k, subject_.frame_count());
  silhouettes_[k] = MeshSilhouette(
      subject_.VerticesOf(frame), subject_.surface().faces(), subject_.frame(frame).camera);
  sent_silhouettes_[k].Upload(silhouettes_[k].data(), silhouettes_[k].size(), stream);
  return sent_silhouettes_[k];
}

void DeviceAvatar::Veto(const DeviceGaussians& gaussians,
                        const Canvas& canvas,
                        DeviceView<uint8_t> unwanted) {
  const cudaStream_t stream = canvas.renderer.stream().get();
  if (!IsOurs() || !guard_.Begin(gaussians, embedding_, {unwanted.data, unwanted.count}, stream))
    return;
  for (size_t k = 0; k < std::min(math::kHoleFrames, subject_.frame_count()); ++k) {
    const size_t frame = math::HoleFrame(k, subject_.frame_count());
    WorldGaussians world = Place(gaussians, frame, stream);
    world.color_frame = nullptr;  // no colour is looked at
    guard_.Spare(canvas, world, subject_.frame(frame).camera, SilhouetteOf(k, stream), unwanted);
  }
}

void DeviceAvatar::Store(cudaStream_t stream) {
  const AvatarTrainingState& state = subject_.state();
  triangles_changed_ = true;
  embedding_.Upload(state.embedding, surface_.face_count(), stream);
  first_triangle_.Upload(state.first_triangle.data(), state.first_triangle.size(), stream);
}

void DeviceAvatar::Fetch(cudaStream_t stream) {
  Embedding embedding;
  std::vector<int32_t> first_triangle(first_triangle_.size());
  embedding_.Download(embedding, stream);
  first_triangle_.Download(first_triangle.data(), stream);
  Check(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  subject_.SetPlaces(std::move(embedding), std::move(first_triangle));
}

std::vector<MemoryPart> DeviceAvatar::Memory() const {
  size_t silhouettes = 0;
  for (const DeviceBuffer<uint8_t>& s : sent_silhouettes_) silhouettes += HeldBy(s);
  return {{"places on the mesh",
           embedding_.held() + HeldBy(first_triangle_, rate_scale_) + walk_.held() +
               placement_.held() + guard_.held()},
          {"posed Gaussians", posed_.held() + d_posed_.held() + binding_.held()},
          {"looking for holes", guard_.HeldForPixels() + silhouettes, MemoryOf::kPixels},
          {"mesh and its poses",
           surface_.held() + mesh_.held() + vertices_.held() + embedding_.HeldForMesh() +
               binding_.HeldForMesh() + walk_.HeldForMesh() + placement_.HeldForSearches() +
               HeldBy(face_rates_, d_vertices_),
           MemoryOf::kFixed}};
}

size_t DeviceAvatar::BytesPerGaussian() const {
  return 2 * DevicePosed::kBytesPerGaussian + DeviceEmbedding::kBytesPerGaussian + sizeof(int32_t) +
         3 * sizeof(float) + DeviceWalk::kBytesPerGaussian + DevicePlacement::kBytesPerGaussian +
         HoleGuard::kBytesPerGaussian + (refines_ ? DeviceBinding::kBytesPerCorners : 0);
}

StepEngineMaker MakeDeviceAvatarEngine(SumOrder order, AvatarSubject& subject) {
  return
      [order, &subject](const TrainSettings& settings, Subject& of_trainer, TrainingState& state) {
        return MakeDeviceStepEngine(order, std::make_shared<DeviceAvatar>(subject, kVertexBytes))(
            settings, of_trainer, state);
      };
}

}  // namespace cosplat::cuda

#include "avatar/train/trainer.h"

#include "avatar/model/avatar_model.h"
#include "avatar/model/bust.h"
#include "avatar/model/corrections.h"
#include "avatar/play/player.h"
#include "avatar/surface/kernels/place.h"
#include "splat/base/error.h"
#include "splat/device/for_each.h"

namespace cosplat {
namespace {

// SplattingAvatar's lengths, in units of its enlarged mesh.
constexpr float kSplitScale = 0.02f;
constexpr float kMaxScale = 0.2f;
constexpr float kNeedleScale = 0.008f;

// Concurrent searches over the mesh, each with 12 kB. One round of density control on a head
// creates some hundred children.
constexpr size_t kDeviceSearchers = 1024;
// Limit of the cache of posed vertices on a device: 8,000 frames of FLAME.
constexpr size_t kPosedVertexBytes = size_t(480) << 20;

}  // namespace

void ScaleToUnit(float unit, TrainSettings& settings) {
  settings.density.split_scale = kSplitScale * unit;
  settings.density.max_scale = kMaxScale * unit;
  settings.scale_regularizer.limit = kNeedleScale * unit;
  settings.scale_regularizer.weight /= unit;
}

AvatarSubject::~AvatarSubject() = default;

AvatarTrainingState AvatarSubject::State() const {
  AvatarTrainingState state;
  state.embedding.released = embedding_.released;
  embedding_.triangle.Download(state.embedding.triangle, *stream_);
  embedding_.barycentric.Download(state.embedding.barycentric, *stream_);
  first_triangle_.Download(state.first_triangle, *stream_);
  stream_->Wait();
  if (settings_.refine_track) state.track = track_;
  state.busts = bust_track_.States();
  state.lights = light_.States();
  return state;
}

std::shared_ptr<SubjectState> AvatarSubject::SaveState() const {
  return std::make_shared<AvatarTrainingState>(State());
}

// The track, whose frames and coefficients are there, and the busts keep their numbers.
void AvatarTrainingState::Serialize(StateArchive& a, size_t count) {
  a.Array("embedding.triangle", embedding.triangle, count);
  a.Array("embedding.barycentric", embedding.barycentric, count);
  a.Array("first_triangle", first_triangle, count);
  for (size_t f = 0; f < track.size(); ++f) {
    const std::string name = "track." + std::to_string(f);
    a.Value(name + ".step", track[f].step);
    for (AvatarPoser::Parameters* p : {&track[f].params, &track[f].m, &track[f].v}) {
      a.Array(name + ".expression", p->expression, p->expression.size());
      a.Value(name + ".pose", p->pose);
      a.Value(name + ".translation", p->translation);
      a.Value(name + ".bust", p->bust);
    }
  }
  a.Array("busts", busts, busts.size());
  a.Array("lights", lights, lights.size());
}

void AvatarSubject::RestoreState(const SubjectState& saved) {
  const auto& state = dynamic_cast<const AvatarTrainingState&>(saved);
  const int32_t faces = int32_t(mesh_.faces.size());
  for (const Buffer<int32_t>* triangles : {&state.embedding.triangle, &state.first_triangle})
    for (const int32_t triangle : *triangles)
      if (triangle < 0 || triangle >= faces)
        throw Error(
            "checkpoint",
            "embedding.triangle",
            std::to_string(triangle) + " is not one of the mesh's " + std::to_string(faces));
  SetEmbedding(EmbeddingIn(*stream_, state.embedding), state.first_triangle);
  if (settings_.refine_track) track_ = state.track;
  bust_track_.SetStates(state.busts);
  light_.SetStates(state.lights);
}

Embedding AvatarSubject::EmbeddingIn(Stream& stream, const Embedding& on_host) {
  if (stream.on_host()) return on_host;
  Embedding embedding;
  UploadEmbedding(on_host, embedding, stream);
  stream.Wait();
  return embedding;
}

void AvatarSubject::SetEmbedding(Embedding embedding, const Buffer<int32_t>& first_triangle) {
  first_triangle_.Upload(first_triangle, *stream_);
  stream_->Wait();
  embedding_ = std::move(embedding);
  TrianglesChanged();
}

// Leaves the subject unchanged on failure, for example when the device is out of memory.
void AvatarSubject::WorkIn(Stream& stream) {
  if (&stream == stream_) return;
  const AvatarTrainingState state = State();
  const bool on_host = stream.on_host();
  Embedding embedding = EmbeddingIn(stream, state.embedding);
  Surface surface(mesh_, stream);
  Buffer<float> face_rates;
  face_rates.Upload(face_rates_on_host_, stream);
  // Allocated now, because later, when children have to be placed, memory may be exhausted.
  Buffer<math::FaceSearch> searches;
  searches.Refill(on_host ? kHostSearchers : kDeviceSearchers, stream);
  stream.Wait();
  // Cached on a device only, where sending takes longer than posing.
  const bool keeps = !on_host && !settings_.refine_track;
  posed_vertices_ =
      PosedVertices(frame_count(), surface.vertex_count(), keeps ? kPosedVertexBytes : 0);
  silhouettes_ = {};
  bust_track_.WorkIn(stream);
  light_.WorkIn(stream);
  stream_ = &stream;
  surface_ = std::move(surface);
  face_rates_ = std::move(face_rates);
  searches_ = std::move(searches);
  SetEmbedding(std::move(embedding), state.first_triangle);
}

AvatarModel AvatarSubject::Model(const Gaussians& gaussians) const {
  AvatarModel model;
  model.embedding = State().embedding;
  model.mesh = mesh_;
  model.canonical_frame = canonical_frame_;
  model.gaussians = gaussians;
  model.bust = bust_;
  if (!bust_track_.empty()) {
    const std::vector<FlameParams> track = RefinedTrack();
    std::vector<FlameParams> heads;
    for (const size_t frame : bust_track_.first_frames()) heads.push_back(track[frame]);
    model.bust->follow = FitBustFollow(*bust_, heads, bust_track_.Poses());
  }
  model.color_frame = settings_.color_frame;
  model.flame_name = flame_.name;
  model.flame_sha256 = flame_.sha256;
  model.has_mouth = flame_.mouth.count() > 0;
  model.has_eyelids = flame_.has_eyelids;
  model.shape = video_.shape;
  model.static_offset = video_.static_offset;
  model.trained_range = RangeOf(RefinedTrack());
  model.correction_map = correction_map_;
  light_.Settle(model);
  return model;
}

double AvatarSubject::WalkedShare() const {
  const AvatarTrainingState state = State();
  size_t walked = 0;
  for (size_t i = 0; i < state.first_triangle.size(); ++i)
    walked += state.embedding.triangle[i] != state.first_triangle[i];
  return state.first_triangle.empty() ? 0 : double(walked) / double(state.first_triangle.size());
}

std::vector<FlameParams> AvatarSubject::RefinedTrack() const {
  std::vector<FlameParams> track;
  for (const RefinedFrame& frame : track_) {
    FlameParams p;
    p.expression = frame.params.expression;
    p.pose = frame.params.pose;
    p.translation = frame.params.translation;
    track.push_back(p);
  }
  return track;
}

void AvatarSubject::TrianglesChanged() {
  rates_known_ = false;
  scratch_.by_face.Forget();
}

const std::vector<float>& AvatarSubject::VerticesOf(size_t i) {
  poser_->Forward(track_[i].params, vertices_);
  return vertices_;
}

WorldGaussians AvatarSubject::ToWorld(const Gaussians& gaussians, size_t i) {
  current_ = i;
  const auto pose = [&]() -> const std::vector<float>& {
    const std::vector<float>& vertices = VerticesOf(i);
    if (!stream_->on_host()) surface_.CheckVertices(vertices);
    return vertices;
  };
  const View<float> vertices = posed_vertices_.Of(i, pose, *stream_);
  if (!bust_track_.empty()) bust_track_.PoseBust(i, vertices);
  surface_.Pose(vertices);
  const std::vector<float> weights = CorrectionWeights(correction_map_, track_[i].params);
  weights_.Refill(weights.size(), *stream_);
  stream_->Send(weights_.data(), weights.data(), weights.size() * sizeof(float));
  Bind(gaussians, embedding_, surface_, posed_, CurrentAppearance());
  return PosedView(gaussians, posed_, settings_.color_frame);
}

Appearance AvatarSubject::CurrentAppearance() const {
  return {weights_.view(), light_.light(), light_.mean()};
}

WorldGradients AvatarSubject::WorldGradientsFor(Gaussians& gradients,
                                                Buffer<float>& screen,
                                                Stream& stream) {
  d_posed_.Refill(gradients.size(), stream);
  WorldGradients view = GradientViewOf(gradients, screen, stream);
  view.position = d_posed_.position.data();
  view.rotation = d_posed_.rotation.data();
  view.scale_log = d_posed_.scale_log.data();
  if (settings_.color_frame == ColorFrame::kSurface)
    view.color_frame = d_posed_.frame.data();
  else
    d_posed_.frame.clear();
  return view;
}

void AvatarSubject::ToWorldBackward(const Gaussians& gaussians,
                                    Gaussians& gradients,
                                    const uint32_t* overflowed) {
  if (!bust_track_.empty())
    bust_track_.Advance(current_, embedding_, flame_.faces.size(), posed_, d_posed_, overflowed);
  const bool refines = settings_.refine_track;
  BindBackward(gaussians,
               embedding_,
               surface_,
               d_posed_,
               gradients,
               refines ? &d_vertices_ : nullptr,
               scratch_,
               CurrentAppearance(),
               light_.gradient());
  if (!light_.empty()) light_.Advance(overflowed);
  if (!refines) return;
  if (stream_->on_host()) return RefineFrame(d_vertices_);
  RefineFrame(d_vertices_.Downloaded(*stream_));
}

void AvatarSubject::RefineFrame(View<const float> d_vertices) {
  RefinedFrame& frame = track_[current_];
  frame.Step(poser_->Backward(frame.params, d_vertices),
             {settings_.expression_rate,
              settings_.pose_rate,
              settings_.translation_rate * kEnlarged * unit_});
}

View<const float> AvatarSubject::PositionRateScale() {
  if (!std::exchange(rates_known_, true)) {
    const size_t n = embedding_.triangle.size();
    rate_scale_.Refill(3 * n, *stream_);
    ForEach(n,
            *stream_,
            RateEach{
                std::as_const(face_rates_).view(), embedding_.triangle.data(), rate_scale_.view()});
  }
  return std::as_const(rate_scale_).view();
}

void AvatarSubject::Change(int, Gaussians& gaussians, AdamState& adam) {
  walk_.Run(surface_, kBoundaryFaceCap, scratch_.by_face, embedding_, gaussians.values[kPosition]);
  Buffer<float>& bases = gaussians.values[kCorrection];
  ForEach(bases.size(), *stream_, ScaleEach{bases.view(), 1 - settings_.correction_decay});
  Buffer<float>& bands = gaussians.values[kColorRest];
  if (IsOurs()) ForEach(bands.size(), *stream_, ScaleEach{bands.view(), 1 - settings_.band_decay});
  for (Gaussians* moments : {&adam.m, &adam.v})
    walk_.ResetMoment(moments->values[kPosition], *stream_);
  TrianglesChanged();
}

std::vector<MemoryPart> AvatarSubject::Memory() const {
  if (stream_->on_host()) return {};
  size_t silhouettes = 0;
  for (const Buffer<uint8_t>& s : silhouettes_) silhouettes += AllocatedBytes(s);
  return {
      {"embedding",
       AllocatedBytes(embedding_.triangle, embedding_.barycentric, spare_triangle_) +
           AllocatedBytes(spare_barycentric_, first_triangle_, rate_scale_, centers_) +
           scratch_.by_face.allocated_bytes() + walk_.allocated_bytes() + holes_.allocated_bytes()},
      {"posed Gaussians",
       posed_.allocated_bytes() + d_posed_.allocated_bytes() +
           AllocatedBytes(scratch_.d_corners, scratch_.d_log_light)},
      {"hole detection", holes_.PixelBytes() + silhouettes, MemoryOf::kPixels},
      {"mesh and posed vertices",
       surface_.allocated_bytes() + posed_vertices_.allocated_bytes() +
           scratch_.by_face.MeshBytes() + walk_.MeshBytes() + light_.allocated_bytes() +
           AllocatedBytes(scratch_.d_surface, searches_, face_rates_, d_vertices_),
       MemoryOf::kFixed}};
}

size_t AvatarSubject::BytesPerGaussian() const {
  const size_t place = sizeof(int32_t) + 2 * sizeof(float);
  return 2 * PosedGaussians::kBytesPerGaussian + 2 * place + FaceLists::kBytesPerGaussian +
         sizeof(int32_t) + 6 * sizeof(float) + TriangleWalk::kBytesPerGaussian +
         HoleGuard::kBytesPerGaussian + (light_.empty() ? 0 : LightFit::kBytesPerGaussian) +
         (settings_.refine_track ? BindScratch::kBytesPerGaussian : 0);
}

}  // namespace cosplat

#include "avatar/train/avatar_subject.h"

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
  state.embedding = embedded_.EmbeddingOnHost();
  state.first_triangle = embedded_.FirstTriangles();
  if (settings_.refine_track) state.track = track_.frames;
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
  const int32_t faces = int32_t(subject_.mesh.faces.size());
  for (const Buffer<int32_t>* triangles : {&state.embedding.triangle, &state.first_triangle})
    for (const int32_t triangle : *triangles)
      if (triangle < 0 || triangle >= faces)
        throw Error(
            "checkpoint",
            "embedding.triangle",
            std::to_string(triangle) + " is not one of the mesh's " + std::to_string(faces));
  embedded_ = EmbeddedGaussians(state.embedding, state.first_triangle, face_rates_, *stream_);
  if (settings_.refine_track) track_.frames = state.track;
  bust_track_.SetStates(state.busts);
  light_.SetStates(state.lights);
}

// Leaves the subject unchanged on failure, for example when the device is out of memory.
void AvatarSubject::WorkIn(Stream& stream) {
  if (&stream == stream_) return;
  const AvatarTrainingState state = State();
  EmbeddedGaussians embedded(state.embedding, state.first_triangle, face_rates_, stream);
  Surface surface(subject_.mesh, stream);
  stream.Wait();
  // Cached on a device only, where sending takes longer than posing.
  const bool keeps = !stream.on_host() && !settings_.refine_track;
  posed_vertices_ =
      PosedVertices(FaceCount(), surface.vertex_count(), keeps ? kPosedVertexBytes : 0);
  silhouettes_ = {};
  bust_track_.WorkIn(stream);
  light_.WorkIn(stream);
  stream_ = &stream;
  surface_ = std::move(surface);
  embedded_ = std::move(embedded);
}

AvatarModel AvatarSubject::Model(const Gaussians& gaussians) const {
  AvatarModel model;
  model.embedding = State().embedding;
  model.mesh = subject_.mesh;
  model.canonical_frame = subject_.canonical_frame;
  model.gaussians = gaussians;
  model.bust = subject_.bust;
  if (!bust_track_.empty()) {
    const std::vector<FlameParams> track = RefinedTrack();
    std::vector<FlameParams> heads;
    for (const size_t frame : bust_track_.first_frames()) heads.push_back(track[frame]);
    model.bust->follow = FitBustFollow(*subject_.bust, heads, bust_track_.Poses());
  }
  model.color_frame = settings_.color_frame;
  model.flame_name = flame_.name;
  model.flame_sha256 = flame_.sha256;
  model.flame_file = flame_.file;
  model.has_mouth = flame_.mouth.count() > 0;
  model.has_eyelids = flame_.has_eyelids;
  model.shape = video_.shape;
  model.static_offset = video_.static_offset;
  model.trained_range = RangeOf(RefinedTrack());
  model.filmed = filmed_;
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
  for (const RefinedFrame& frame : track_.frames) {
    FlameParams p;
    p.expression = frame.params.expression;
    p.pose = frame.params.pose;
    p.translation = frame.params.translation;
    track.push_back(p);
  }
  return track;
}

WorldGaussians AvatarSubject::ToWorld(const Gaussians& gaussians, size_t i) {
  bound_.is_real = i < track_.frames.size();
  bound_.index = FrameOf(i);
  const AvatarPoser::Parameters& face = FaceIn(i);
  const auto pose = [&]() -> const std::vector<float>& {
    const std::vector<float>& vertices = track_.VerticesOf(face);
    if (!stream_->on_host()) surface_.CheckVertices(vertices);
    return vertices;
  };
  // Views of one face share its place in the cache.
  const size_t place = i < FaceCount() ? i : bound_.index;
  const View<float> vertices = posed_vertices_.Of(place, pose, *stream_);
  if (!bust_track_.empty()) bust_track_.PoseBust(bound_.index, vertices);
  surface_.Pose(vertices);
  const std::vector<float> weights = CorrectionWeights(correction_map_, face);
  bound_.weights.Refill(weights.size(), *stream_);
  stream_->Send(bound_.weights.data(), weights.data(), weights.size() * sizeof(float));
  Bind(gaussians, embedded_.embedding(), surface_, bound_.posed, CurrentAppearance());
  return PosedView(gaussians, bound_.posed, settings_.color_frame);
}

Appearance AvatarSubject::CurrentAppearance() const {
  return {bound_.weights.view(), light_.light(), light_.mean()};
}

WorldGradients AvatarSubject::WorldGradientsFor(Gaussians& gradients,
                                                Buffer<float>& screen,
                                                Stream& stream) {
  bound_.d_posed.Refill(gradients.size(), stream);
  WorldGradients view = GradientViewOf(gradients, screen, stream);
  view.position = bound_.d_posed.position.data();
  view.rotation = bound_.d_posed.rotation.data();
  view.scale_log = bound_.d_posed.scale_log.data();
  if (settings_.color_frame == ColorFrame::kSurface)
    view.color_frame = bound_.d_posed.frame.data();
  else
    bound_.d_posed.frame.clear();
  return view;
}

void AvatarSubject::ToWorldBackward(const Gaussians& gaussians,
                                    Gaussians& gradients,
                                    const uint32_t* overflowed) {
  if (!bust_track_.empty() && bound_.is_real)
    bust_track_.Advance(bound_.index,
                        embedded_.embedding(),
                        flame_.faces.size(),
                        bound_.posed,
                        bound_.d_posed,
                        overflowed);
  const bool refines = settings_.refine_track && bound_.is_real;
  BindBackward(gaussians,
               embedded_.embedding(),
               surface_,
               bound_.d_posed,
               gradients,
               refines ? &bound_.d_vertices : nullptr,
               embedded_.scratch(),
               CurrentAppearance(),
               light_.gradient());
  if (!light_.empty() && bound_.is_real) light_.Advance(overflowed);
  if (!refines) return;
  if (stream_->on_host()) return RefineFrame(bound_.d_vertices);
  RefineFrame(bound_.d_vertices.Downloaded(*stream_));
}

void AvatarSubject::RefineFrame(View<const float> d_vertices) {
  RefinedFrame& frame = track_.frames[bound_.index];
  frame.Step(track_.poser->Backward(frame.params, d_vertices),
             {settings_.expression_rate,
              settings_.pose_rate,
              settings_.translation_rate * kEnlarged * subject_.unit});
}

void AvatarSubject::Change(int, Gaussians& gaussians, AdamState& adam) {
  embedded_.Walk(surface_, gaussians, adam);
  Buffer<float>& bases = gaussians.values[kCorrection];
  ForEach(bases.size(), *stream_, ScaleEach{bases.view(), 1 - settings_.correction_decay});
  Buffer<float>& bands = gaussians.values[kColorRest];
  if (!IsOurs()) return;
  ForEach(bands.size(), *stream_, ScaleEach{bands.view(), 1 - settings_.band_decay});
}

std::vector<MemoryPart> AvatarSubject::Memory() const {
  if (stream_->on_host()) return {};
  size_t silhouettes = 0;
  for (const Buffer<uint8_t>& s : silhouettes_) silhouettes += AllocatedBytes(s);
  return {{"embedding", embedded_.allocated_bytes() + holes_.allocated_bytes()},
          {"posed Gaussians", bound_.posed.allocated_bytes() + bound_.d_posed.allocated_bytes()},
          {"hole detection", holes_.PixelBytes() + silhouettes, MemoryOf::kPixels},
          {"mesh and posed vertices",
           surface_.allocated_bytes() + posed_vertices_.allocated_bytes() + embedded_.MeshBytes() +
               light_.allocated_bytes() + AllocatedBytes(bound_.d_vertices),
           MemoryOf::kFixed}};
}

size_t AvatarSubject::BytesPerGaussian() const {
  return 2 * PosedGaussians::kBytesPerGaussian + EmbeddedGaussians::kBytesPerGaussian +
         HoleGuard::kBytesPerGaussian + (light_.empty() ? 0 : LightFit::kBytesPerGaussian) +
         (settings_.refine_track ? BindScratch::kBytesPerGaussian : 0);
}

}  // namespace cosplat

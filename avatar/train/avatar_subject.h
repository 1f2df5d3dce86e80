// Head avatars in the training loop of splat/train/trainer.h.
//
// TrackedVideo frame -> FlamePoser -> Surface -> Bind -> rasteriser -> loss -> BindBackward ->
// Adam; with --refine-track also for the frame's pose, translation and expression. At regular
// intervals Gaussians walk on the triangles, and density control re-embeds the Gaussians that it
// splits. Source: Shao et al. 2024 (SplattingAvatar).
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "avatar/model/avatar_mesh.h"
#include "avatar/model/avatar_model.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/kernels/holes.h"
#include "avatar/surface/surface.h"
#include "avatar/train/bust_track.h"
#include "avatar/train/embedded_gaussians.h"
#include "avatar/train/hole_guard.h"
#include "avatar/train/light_fit.h"
#include "avatar/train/mesh_in_frame.h"
#include "avatar/train/posed_vertices.h"
#include "avatar/train/refined_frame.h"
#include "avatar/train/virtual_faces.h"
#include "flame/model.h"
#include "flame/track.h"
#include "splat/render/device.h"
#include "splat/train/step/step_engine.h"
#include "splat/train/trainer.h"

namespace cosplat {

class PaintedMesh;

// Selects between this project's and SplattingAvatar's (Shao et al. 2024) choices where they differ
// and no separate option selects them.
//
//                       kCosplat                   kPublished           kReleased
//   canonical mesh      the shape at rest          as posed by training frame 0
//   first Gaussians     evenly over the area       likewise             evenly over the faces
//   their scale         from an even spacing       distance to the nearest others (3DGS)
//   lr of du and dv     that of d, in metres       the number for d, in barycentric units
//   split children      re-embedded                re-embedded, with their parent's d
//   pruning             opens no holes             may open holes
//   follows the mesh    avatar/math/embed.h        likewise             avatar/math/released.h
//
// The last row contains the release's faults. kReleased does not walk either, since du and dv do
// not affect its mean.
enum class AvatarSystem { kCosplat, kPublished, kReleased };

struct AvatarSettings {
  AvatarSystem system = AvatarSystem::kCosplat;
  size_t initial_gaussians = 10000;  // SplattingAvatar
  ColorFrame color_frame = ColorFrame::kSurface;
  int walk_every = 100;  // steps (SplattingAvatar)
  // A bust for the region below the neck; kAuto adds it if the masks show more than the mesh
  // covers.
  enum class BustChoice { kAuto, kYes, kNo } bust = BustChoice::kAuto;
  bool still_bust = false;  // it stays at its mean place, instead of being found in each frame
  BustRates bust_rates;
  int iterations = 6000;  // length of the run, over which some learning rates fall
  // Most bases per Gaussian that follow the expression (avatar/math/correct.h).
  size_t corrections = 0;
  // By how much a walk's time shrinks corrections (decoupled weight decay, Loshchilov & Hutter
  // 2019): a short video shows few expressions, and without it the bases learn its noise.
  float correction_decay = 0.1f;
  // By how much a walk's time shrinks the colours' bands from 1 on, likewise: seen from where no
  // frame showed it, a Gaussian then has its base colour, and not what a fit to other directions
  // happens to be there.
  float band_decay = 0.05f;
  // Adam's learning rate of the light of the world (avatar/math/light.h), which falls to zero over
  // the run; 0: no light.
  float light_rate = 5e-3f;
  // Of the steps after density control, the share that sees the head from where no camera was
  // (virtual_views.h), if it does not turn; less if it does. Frames need masks.
  float virtual_views = 0.15f;
  bool refine_track = false;
  // GaussianAvatars' learning rates for the track.
  float pose_rate = 1e-5f;         // radians per step
  float translation_rate = 1e-6f;  // metres per step, on a head of the template's size
  float expression_rate = 1e-3f;
};

// SplattingAvatar enlarges FLAME's mesh, and gives lengths in units of the enlarged one.
constexpr float kEnlarged = 4;

// Sets SplattingAvatar's lengths in metres of this subject: the clone/split threshold 0.02, the
// largest scale 0.2 and the scale 0.008 above which needle-like (high-anisotropy) Gaussians are
// penalised, all times `unit` (metres per unit of a 4x FLAME mesh). The weight of that penalty,
// which is given for lengths in those units, is divided by `unit`.
void ScaleToUnit(float unit, TrainSettings& settings);

// The state of an avatar's training run that TrainingState does not contain; both together are an
// exact checkpoint.
struct AvatarTrainingState : SubjectState {
  Embedding embedding;
  Buffer<int32_t> first_triangle;   // [N] on which it, or its first ancestor, began
  std::vector<RefinedFrame> track;  // [training frames] with --refine-track, or empty
  std::vector<BustState> busts;     // [training frames], or empty
  std::vector<LightState> lights;   // [1], or empty

  void Serialize(StateArchive& archive, size_t count) override;
};

// What is fitted to the subject before training.
struct SubjectMesh {
  explicit SubjectMesh(CanonicalMesh of_head) : mesh(std::move(of_head)), unit(MeshUnit(mesh)) {}

  std::optional<Bust> bust;
  std::optional<FlameParams> canonical_frame;  // null: at rest
  CanonicalMesh mesh;                          // with the bust
  float unit;                                  // metres per unit of a 4x FLAME mesh
};

// The parameters of the training frames, and the meshes that they pose.
struct PosedTrack {
  std::vector<RefinedFrame> frames;  // they change only with --refine-track
  std::unique_ptr<AvatarPoser> poser;

  // [V, 3] metres; valid until the next call.
  const std::vector<float>& VerticesOf(const AvatarPoser::Parameters& face) {
    poser->Forward(face, vertices_);
    return vertices_;
  }
  const std::vector<float>& VerticesOf(size_t i) { return VerticesOf(frames[i].params); }

 private:
  std::vector<float> vertices_;
};

// The frame that is drawn: its Gaussians in the world, and their gradients.
struct BoundFrame {
  size_t index = 0;       // of the training frame
  bool is_real = true;    // false: a virtual view of it, which teaches Gaussians alone
  Buffer<float> weights;  // [corrections]
  PosedGaussians posed, d_posed;
  Buffer<float> d_vertices;  // with --refine-track
};

// Works on the host or on a device. On a device, posed vertices of the frames are cached, up to a
// limit. If the track is refined they are posed and sent every time instead, and the host waits for
// dL/d(vertices).
class AvatarSubject : public Subject {
 public:
  // Loads all training images. Frames whose image cannot be used are added to `video.skipped`.
  // Throws Error if these are more than a third of all frames, and for refine_track with kReleased,
  // whose rule has no derivative for it. Keeps a reference to `flame`.
  AvatarSubject(const FlameModel& flame, TrackedVideo video, const AvatarSettings& settings);
  ~AvatarSubject() override;

  // The first Gaussians: isotropic, grey, opacity 0.1, distributed as AvatarSettings::system says;
  // none where the mesh is beyond all frames. To be called before training.
  Gaussians InitialGaussians(int degree, Basis basis, uint64_t seed);

  // The current avatar with the trainer's Gaussians.
  AvatarModel Model(const Gaussians& gaussians) const;
  // In host memory, also when working on a device.
  AvatarTrainingState State() const;
  const TrackedVideo& video() const { return video_; }
  // In the memory of the current stream.
  const Surface& surface() const { return surface_; }
  size_t virtual_view_count() const { return other_faces_.size() + view_sources_.size(); }
  // Whether the frames say where the person is.
  bool IsMasked() const;
  bool has_bust() const { return subject_.bust.has_value(); }
  // Fraction of the Gaussians that are on another triangle than they (or their ancestors) began on.
  double WalkedShare() const;
  // The training frames' parameters as refined so far; without --refine-track, those of the track.
  std::vector<FlameParams> RefinedTrack() const;

  // Training frames, then virtual ones: other faces, then other views.
  size_t frame_count() const override { return frames_.size(); }
  const TrainFrame& frame(size_t i) const override { return frames_[i]; }
  bool IsGuess(size_t i) const override { return i >= track_.frames.size(); }
  float extent() const override { return subject_.unit; }
  void WorkIn(Stream& stream) override;
  WorldGaussians ToWorld(const Gaussians& gaussians, size_t i) override;
  WorldGradients WorldGradientsFor(Gaussians& gradients,
                                   Buffer<float>& screen,
                                   Stream& stream) override;
  void ToWorldBackward(const Gaussians& gaussians,
                       Gaussians& gradients,
                       const uint32_t* overflowed) override;
  bool WaitsInSteps() const override { return settings_.refine_track; }
  View<const float> PositionRateScale() override { return embedded_.RateScale(); }
  bool ChangesAfter(int iteration) const override { return iteration % settings_.walk_every == 0; }
  void Change(int iteration, Gaussians& gaussians, AdamState& adam) override;
  std::shared_ptr<SubjectState> SaveState() const override;
  void RestoreState(const SubjectState& state) override;

  void Gather(View<const uint32_t> source, Stream&) override { embedded_.Gather(source); }
  void Move(View<const float> offsets, size_t first, Gaussians& gaussians, Stream& stream) override;
  View<const float> Centers(const Gaussians& gaussians, Stream&) override {
    return embedded_.Centers(surface_, gaussians);
  }
  std::vector<int32_t> Groups(Stream&) override { return embedded_.Triangles(); }
  void Veto(const Gaussians& gaussians,
            const Canvas* canvas,
            View<uint8_t> unwanted,
            Stream& stream) override;

  std::vector<MemoryPart> Memory() const override;
  size_t BytesPerGaussian() const override;

 private:
  void LoadFrames();
  bool NeedsBust() const;
  Bust MeanBustOfTrack() const;
  void StartBustTrack();
  void StartLight();
  MeshInFrame MeshIn(size_t frame);
  void AddVirtualViews();
  void AddWideViews(const PaintedMesh& painted, size_t count, std::vector<TrainFrame>& views);
  void AddVirtualFaces(const PaintedMesh& painted, size_t count);
  Appearance CurrentAppearance() const;
  void BuildMesh();
  void SetFaceRates();
  void SetSpacing(Gaussians& gaussians);
  // The training frame whose head frame(i) shows.
  size_t FrameOf(size_t i) const {
    return i < track_.frames.size() ? i
           : i < FaceCount()        ? other_faces_[i - track_.frames.size()].source
                                    : view_sources_[i - FaceCount()];
  }
  // What its face is in frame(i).
  const AvatarPoser::Parameters& FaceIn(size_t i) const {
    return i >= track_.frames.size() && i < FaceCount()
               ? other_faces_[i - track_.frames.size()].params
               : track_.frames[FrameOf(i)].params;
  }
  bool IsOurs() const { return settings_.system == AvatarSystem::kCosplat; }
  // Training frames, and those that have a face of their own.
  size_t FaceCount() const { return track_.frames.size() + other_faces_.size(); }
  // One Adam step on the parameters of the current frame. d_vertices: in host memory.
  void RefineFrame(View<const float> d_vertices);
  // Silhouette of the mesh in the k-th frame that is searched for holes.
  const Buffer<uint8_t>& SilhouetteOf(size_t k);

  const FlameModel& flame_;
  TrackedVideo video_;
  AvatarSettings settings_;
  SubjectMesh subject_;
  std::vector<TrainFrame> frames_;  // the training frames, then virtual ones
  FilmedFrom filmed_;
  std::vector<uint8_t> beyond_frames_;  // [F] faces that are far beyond all frames, or empty
  std::vector<VirtualFace> other_faces_;
  std::vector<size_t> view_sources_;  // training frames
  PosedTrack track_;
  std::vector<float> face_rates_;  // [F] factors on the learning rates of du and dv on each face
  CorrectionMap correction_map_;
  BustTrack bust_track_;
  LightFit light_;

  // In the memory of the current stream.
  Stream* stream_ = &HostStream();
  Surface surface_;
  EmbeddedGaussians embedded_;
  PosedVertices posed_vertices_;
  BoundFrame bound_;
  HoleGuard holes_;
  std::array<Buffer<uint8_t>, math::kHoleFrames> silhouettes_;
};

// For Trainer: as StepEngineOn (splat/train/step/step_engine.h), for avatars. On a device the
// engine throws Error for AvatarSystem::kReleased, whose rule only the CPU supports.
StepEngineMaker AvatarEngineOn(Device device, bool deterministic);

}  // namespace cosplat

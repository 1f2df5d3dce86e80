// Head avatars in the training loop of splat/train/trainer.h.
//
// TrackedVideo frame -> FlamePoser -> Surface -> Bind -> rasteriser -> loss -> BindBackward ->
// Adam; with --refine-track on to the frame's pose, translation and expression. Every so often
// Gaussians walk on the triangles, and density control re-embeds what it splits. Source: Shao et
// al. 2024 (SplattingAvatar).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "avatar/model/avatar_mesh.h"
#include "avatar/model/avatar_model.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/surface.h"
#include "avatar/surface/walk.h"
#include "flame/model.h"
#include "flame/track.h"
#include "splat/train/trainer.h"

namespace cosplat {

// Whose choices are made where SplattingAvatar's (Shao et al. 2024) and ours differ and no option
// says which.
//
//                       kCosplat                   kPublished           kReleased
//   canonical mesh      the shape at rest          as training frame 0 poses it
//   first Gaussians     evenly over the area       likewise             alike over all faces
//   their scale         of an even spacing         distance to the nearest others (3DGS)
//   rate of du and dv   that of d, in metres       the number for d, in barycentric units
//   a split's children  re-embedded                with their parent's d
//   removal             tears no hole              may
//   follows the mesh    avatar/math/embed.h        likewise             avatar/math/released.h
//
// The last is where the release's faults are: it does not walk either, since du and dv have no part
// in its mean.
enum class AvatarSystem { kCosplat, kPublished, kReleased };

struct AvatarSettings {
  AvatarSystem system = AvatarSystem::kCosplat;
  size_t initial_gaussians = 10000;  // SplattingAvatar
  ColorFrame color_frame = ColorFrame::kSurface;
  int walk_every = 100;  // steps (SplattingAvatar)
  // A bust for what lies below the neck: kAuto where the masks show more than the mesh covers.
  enum class BustChoice { kAuto, kYes, kNo } bust = BustChoice::kAuto;
  bool refine_track = false;
  // GaussianAvatars' rates for the track.
  float pose_rate = 1e-5f;         // radians per step
  float translation_rate = 1e-6f;  // metres per step, on a head of the template's size
  float expression_rate = 1e-3f;
};

// Lengths of SplattingAvatar in metres of this subject: clone/split boundary 0.02, largest scale
// 0.2, needles from 0.008, times `unit` (metres per unit of a 4x FLAME mesh); the weight of
// needles, given for lengths in those units, is divided by it.
void ScaleToUnit(float unit, TrainSettings& settings);

// One training frame's parameters with Adam's moments; they change only with --refine-track.
struct RefinedFrame {
  AvatarPoser::Frame params, m, v;
  int64_t step = 0;
};

// What an avatar's run is beside TrainingState: both together make an exact checkpoint.
struct AvatarTrainingState {
  Embedding embedding;
  std::vector<int32_t> first_triangle;  // [N] where it, or its first ancestor, began
  std::vector<RefinedFrame> track;      // [training frames]
};

class AvatarSubject : public Subject {
 public:
  // Loads every training picture. Frames whose picture cannot be used are added to `video.skipped`;
  // more than a third of all frames is an Error, and so is refine_track with kReleased, whose rule
  // has no derivative for it. Keeps a reference to `flame`.
  AvatarSubject(const FlameModel& flame, TrackedVideo video, const AvatarSettings& settings);
  ~AvatarSubject() override;

  // Isotropic, grey, opacity 0.1, spread by AvatarSettings::system.
  Gaussians InitialGaussians(int degree, Basis basis, uint64_t seed);

  // The avatar as it stands, with the trainer's Gaussians.
  AvatarModel Model(const Gaussians& gaussians) const;
  const AvatarTrainingState& state() const { return state_; }
  const TrackedVideo& video() const { return video_; }
  const Surface& surface() const { return surface_; }
  bool has_bust() const { return bust_.has_value(); }
  // Share of the Gaussians that are now on another triangle than they (or their parents) began on.
  double WalkedShare() const;
  // Training frames' parameters as refined so far (equal to the track's without --refine-track).
  std::vector<FlameParams> RefinedTrack() const;

  // What a device needs of it (avatar/train/cuda/device_avatar.h). Vertices of a frame as its track
  // stands, [V, 3] metres, until the next call; and a step of that frame's own parameters.
  const std::vector<float>& VerticesOf(size_t i);
  void RefineFrame(const std::vector<float>& d_vertices);
  const AvatarSettings& settings() const { return settings_; }
  // [F] factors on the rates of du and dv on each face.
  const std::vector<float>& face_rates() const { return face_rates_; }
  // AvatarTrainingState's, as the device has moved them.
  void SetPlaces(Embedding embedding, std::vector<int32_t> first_triangle);

  size_t frame_count() const override { return frames_.size(); }
  const TrainFrame& frame(size_t i) const override { return frames_[i]; }
  float extent() const override { return unit_; }
  WorldGaussians Place(const Gaussians& gaussians, size_t i) override;
  WorldGradients WorldGradientsFor(Gaussians& gradients, Buffer<float>& screen) override;
  void PlaceBackward(const Gaussians& gaussians, Gaussians& gradients) override;
  View<const float> PositionRateScale() override;
  void AfterStep(int iteration, Gaussians& gaussians, AdamState& adam) override;
  std::any SaveState() const override { return state_; }
  void RestoreState(const std::any& state) override {
    state_ = std::any_cast<const AvatarTrainingState&>(state);
  }

  void Gather(const std::vector<uint32_t>& source) override;
  void Move(Gaussians& gaussians, uint32_t i, const std::array<float, 3>& offset) override;
  std::array<float, 3> Center(const Gaussians& gaussians, size_t i) const override;
  std::vector<int32_t> Groups() const override { return state_.embedding.triangle; }
  void Veto(const Gaussians& gaussians, std::vector<uint32_t>& removed) override;

 private:
  using Frame = AvatarPoser::Frame;

  void LoadFrames();
  bool NeedsBust() const;
  Bust MeanBustOfTrack() const;
  void BuildMesh();
  void SetFaceRates();
  void SetSpacing(Gaussians& gaussians) const;
  void PoseFrame(size_t i);
  std::vector<uint32_t> LastOfTheirTriangle(const std::vector<uint32_t>& removed) const;

  const FlameModel& flame_;
  TrackedVideo video_;
  AvatarSettings settings_;
  std::optional<Bust> bust_;
  std::optional<FlameParams> canonical_frame_;
  CanonicalMesh mesh_;
  std::unique_ptr<AvatarPoser> poser_;
  Surface surface_;
  float unit_ = 1;  // metres per unit of a 4x FLAME mesh, for this subject
  std::vector<float> face_rates_;
  std::vector<TrainFrame> frames_;
  size_t current_ = 0;

  AvatarTrainingState state_;
  // Scratch, kept between steps.
  std::vector<float> vertices_, d_vertices_;
  PosedGaussians posed_, d_posed_;
  Buffer<float> rate_scale_;
};

}  // namespace cosplat

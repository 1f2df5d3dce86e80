// Fits the parameters of single frames to their images, with the avatar held fixed.
//
// AvatarModel + frame + image -> TrackFitter::Fit -> parameters of head and bust, and the avatar's
// image there. An evaluation on tracked parameters measures the tracker too; one on fitted
// parameters measures what the avatar can show, as PointAvatar (Zheng et al. 2023) and IMavatar
// (Zheng et al. 2022) report it. Both are worth knowing, so that one never replaces the other.
#pragma once

#include <array>

#include "avatar/model/avatar_mesh.h"
#include "avatar/surface/binding.h"
#include "avatar/train/refined_frame.h"
#include "flame/track.h"
#include "splat/math/adam.h"
#include "splat/render/rasterizer.h"
#include "splat/train/loss/loss.h"

namespace cosplat {

struct FitSettings {
  int steps = 80;
  bool head = true, bust = true;  // which of them is fitted
  // First learning rates; they fall to a twentieth.
  float pose_rate = 2e-3f;           // radians per step
  float translation_rate = 2.5e-4f;  // metres per step
  float expression_rate = 2e-2f;
};

class TrackFitter {
 public:
  // The model must have its mesh. Keeps references to both. Throws Error if the avatar follows
  // the mesh by the released rule, which has no derivative for it.
  TrackFitter(const AvatarModel& model, const FlameModel& flame);

  // Starts at the frame's own parameters, and for the bust where it follows the head. target: of
  // the camera's size.
  void Fit(const TrackedFrame& frame,
           const Image8& target,
           const std::array<float, 3>& background,
           const FitSettings& settings);
  // The loss that Fit lowers, at the frame's own parameters.
  double LossOf(const TrackedFrame& frame,
                const Image8& target,
                const std::array<float, 3>& background);
  // The result of the last fit.
  const AvatarPoser::Parameters& parameters() const { return frame_.params; }
  const std::vector<float>& vertices() const { return vertices_; }  // [V, 3] metres
  const RenderedImage& image() const { return image_; }             // over the background

 private:
  void Begin(const TrackedFrame& frame);
  void Draw(const Camera& camera, const std::array<float, 3>& background);
  void Step(const FitSettings& settings, int step);

  const AvatarModel& model_;
  AvatarPoser poser_;
  Surface surface_;
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RefinedFrame frame_;
  math::AdamMoments<kBustOutputs> bust_{};  // of a turn that follows the pose's, and of the shift
  std::vector<float> vertices_;
  PosedGaussians posed_, d_posed_;
  RenderedImage image_;
  PhotometricLoss loss_;
  Gaussians gradients_;
  Buffer<float> screen_, d_color_, d_vertices_;
  BindScratch scratch_;
};

}  // namespace cosplat

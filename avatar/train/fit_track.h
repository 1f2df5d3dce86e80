// Fits the parameters of single frames to their images, with the avatar held fixed.
//
// AvatarModel + frame + image -> TrackFitter::Fit -> parameters of head and bust, and the avatar's
// image there. An evaluation on tracked parameters measures the tracker too; one on fitted
// parameters measures what the avatar can show, as PointAvatar (Zheng et al. 2023) and IMavatar
// (Zheng et al. 2022) report it. Both are worth knowing, so that one never replaces the other.
#pragma once

#include <array>
#include <vector>

#include "avatar/model/avatar_mesh.h"
#include "avatar/surface/binding.h"
#include "avatar/train/lbfgs.h"
#include "flame/track.h"
#include "splat/render/rasterizer.h"
#include "splat/train/loss/loss.h"

namespace cosplat {

struct FitSettings {
  int draws = 40;                 // of the image, at most
  bool head = true, bust = true;  // which of them is fitted
  // Changes that are alike in the image.
  float pose_unit = 2e-3f;           // radians
  float translation_unit = 2.5e-4f;  // metres
  float expression_unit = 2e-2f;
  // Of squares of the head's changes, in units, in the loss: what an image hardly shows stays as it
  // was tracked. place: of root, neck and translation; face: of jaw, eyes and expression.
  double place_prior = 0, face_prior = 0;
};

// What is learned of the loss by fitting one frame is used for the next.
class TrackFitter {
 public:
  // The model must have its mesh. Keeps references to both. Throws Error if the avatar follows
  // the mesh by the released rule, which has no derivative for it.
  TrackFitter(const AvatarModel& model, const FlameModel& flame, const FitSettings& settings = {});

  // Starts at the frame's own parameters, and for the bust where it follows the head. target: of
  // the camera's size.
  void Fit(const TrackedFrame& frame, const Image8& target, const std::array<float, 3>& background);
  // The loss that Fit lowers, at the frame's own parameters, where there is no change.
  double LossOf(const TrackedFrame& frame,
                const Image8& target,
                const std::array<float, 3>& background);
  // The result of the last fit.
  const AvatarPoser::Parameters& parameters() const { return parameters_; }
  const std::vector<float>& vertices() const { return vertices_; }  // [V, 3] metres
  const RenderedImage& image() const { return image_; }             // over the background

 private:
  // What holds the head's numbers at the start, and its derivative by them, each in its unit.
  double Prior(std::vector<double>& gradient) const;
  // Draws the image of parameters_ and returns its loss.
  double Draw();
  // Of the loss of the image drawn last, by the fitted numbers, each in its unit.
  std::vector<double> Gradient();
  // By a share of a step, in the order of Gradient's numbers.
  AvatarPoser::Parameters Moved(const AvatarPoser::Parameters& from,
                                const std::vector<double>& step,
                                double share) const;

  const AvatarModel& model_;
  const FitSettings settings_;
  AvatarPoser poser_;
  Surface surface_;
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  Lbfgs lbfgs_;
  // Of the frame that is fitted.
  Camera camera_;
  const Image8* target_ = nullptr;
  std::array<float, 3> background_{};
  AvatarPoser::Parameters start_, parameters_;
  std::vector<double> d_prior_;

  std::vector<float> vertices_;
  PosedGaussians posed_, d_posed_;
  RenderedImage image_;
  PhotometricLoss loss_;
  Gaussians gradients_;
  Buffer<float> screen_, d_color_, d_vertices_;
  BindScratch scratch_;
};

}  // namespace cosplat

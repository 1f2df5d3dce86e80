// What the cases of this folder are measured on: the procedural head with Gaussians painted on it,
// bound to a posed mesh by the release's rule and by ours, and drawn.
#pragma once

#include <memory>
#include <vector>

#include "apps/study/avatar_stability/painted_avatar.h"
#include "assets/head/procedural_head.h"
#include "avatar/model/avatar_model.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/surface.h"
#include "flame/pose.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

constexpr int kStudyImage = 160;  // px, width and height

struct StudyHead {
  ProceduralHead head;
  AvatarModel avatar;  // painted, at rest
  FlamePoser<float> poser;
  StudyHead();

  std::vector<float> Vertices(const FlameParams& params) const;  // [V, 3] metres
};

// From the front, the head filling the image; `azimuth` radians towards the subject's left.
Camera StudyCamera(float azimuth = 0);

// The mean and the standard deviation (at least 0.1) of each expression coefficient over the
// script of the demonstration video.
struct ExpressionRange {
  std::vector<float> mean, deviation;
};
ExpressionRange RangeOfExpressions();

// Mouth and jaw open, a smile to one side, cheeks and brows as far as they go.
FlameParams Grimace();

// The largest of a Gaussian's three standard deviations, metres.
float LargestScale(const PosedGaussians& posed, size_t i);

// An avatar on a posed mesh, by both rules.
class BoundBothWays {
 public:
  // `unit`: that the release takes the mesh to be in (ReleasedRule).
  BoundBothWays(const AvatarModel& avatar, float unit);
  explicit BoundBothWays(const AvatarModel& avatar);

  void Pose(const std::vector<float>& vertices);

  struct Way {
    AvatarModel model;
    PosedGaussians posed;
  };
  Way naive, ours;

 private:
  Surface surface_;
};

RenderedImage DrawOver(const BoundBothWays::Way& way,
                       const Camera& camera,
                       const std::array<float, 3>& background);
// Over white.
Image8 ImageOf(const BoundBothWays::Way& way, const Camera& camera);

}  // namespace cosplat

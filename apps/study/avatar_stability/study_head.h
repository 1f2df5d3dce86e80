// Subject of the cases in this folder: the procedural head with Gaussians painted on it, bound to a
// posed mesh by the released code's rule and by ours, and rendered.
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

// Frontal view with the head filling the image; `azimuth` in radians towards the subject's left.
Camera StudyCamera(float azimuth = 0);

// Mean and standard deviation (at least 0.1) of each expression coefficient over the script of the
// demonstration video.
struct ExpressionRange {
  std::vector<float> mean, deviation;
};
ExpressionRange RangeOfExpressions();

// Open mouth and jaw, a one-sided smile, cheeks and brows at full expression.
FlameParams Grimace();

// The largest of a Gaussian's three standard deviations, metres.
float LargestScale(const PosedGaussians& posed, size_t i);

// An avatar on a posed mesh, bound by both rules.
class BoundBothWays {
 public:
  // `unit`: the unit in which the released code assumes the mesh to be (ReleasedRule).
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

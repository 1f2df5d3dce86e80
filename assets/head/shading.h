// Shades the procedural head: soft lights fixed in the world, and view-dependent highlights.
#pragma once

#include <array>
#include <vector>

#include "assets/head/procedural_head.h"
#include "assets/head/raster.h"

namespace cosplat::procedural {

// The pose data needed to shade a frame.
struct ShadedPose {
  std::vector<Vec> vertices;          // posed
  math::Mat3<float> posed_from_rest;  // rotation of the skull
  float blink_left = 0, blink_right = 0;
};

class HeadShader : public Shader {
 public:
  // Keeps references to `head` and `pose`, which must outlive it. `eye`: the camera's centre.
  HeadShader(const ProceduralHead& head, const ShadedPose& pose, const Vec& eye);
  std::array<float, 3> Shade(const SurfacePoint& point) const override;

 private:
  struct Corner {  // attributes interpolated over a face
    Vec rest{}, rest_normal{}, normal{}, position{};
    float occlusion, mouth, lid, along, upper, ear;
  };
  Corner Interpolate(const SurfacePoint& point) const;
  std::array<float, 3> ShadeEye(const Corner& c, bool left) const;
  float LidShadow(const Vec& position, bool left) const;

  const ProceduralHead& head_;
  const ShadedPose& pose_;
  Vec eye_{};  // the camera's centre
  std::vector<Vec> normals_, rest_normals_;
  std::array<Vec, 2> eye_centers_{};
};

}  // namespace cosplat::procedural

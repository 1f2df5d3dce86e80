// Lights the procedural head: a soft rig fixed in the world, and highlights that move with the
// view.
#pragma once

#include <array>
#include <vector>

#include "assets/head/procedural_head.h"
#include "assets/head/raster.h"

namespace cosplat::procedural {

// What a frame's shading needs to know of its pose.
struct ShadedPose {
  std::vector<Vec> vertices;             // posed
  std::array<float, 9> posed_from_rest;  // rotation of the skull, row-major
  float blink_left = 0, blink_right = 0;
};

class HeadShader : public Shader {
 public:
  // Keeps references to `head` and `pose`. `eye`: the camera's centre.
  HeadShader(const ProceduralHead& head, const ShadedPose& pose, const Vec& eye);
  std::array<float, 3> Shade(const SurfacePoint& point) const override;

 private:
  struct Corner {  // what is interpolated over a face
    Vec rest, rest_normal, normal, position;
    float occlusion, mouth, lid, along, upper, ear;
  };
  Corner Interpolate(const SurfacePoint& point) const;
  std::array<float, 3> ShadeEye(const Corner& c, bool left) const;
  float LidShadow(const Vec& position, bool left) const;

  const ProceduralHead& head_;
  const ShadedPose& pose_;
  Vec eye_;  // the camera's centre
  std::vector<Vec> normals_, rest_normals_;
  std::array<Vec, 2> eye_centers_;
};

}  // namespace cosplat::procedural

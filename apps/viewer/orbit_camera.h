// The camera controlled by the mouse: it orbits a point, pans and zooms.
//
// StartView -> OrbitCamera -> At(size) -> Shot (apps/viewer/stage.h).
#pragma once

#include <array>
#include <vector>

#include "flame/model.h"
#include "splat/base/camera.h"
#include "splat/gaussians.h"
#include "splat/math/vec.h"

namespace cosplat::viewer {

// Initial view. World units.
struct StartView {
  Camera camera;
  std::array<float, 3> center{};      // approximate point of interest
  std::array<float, 3> up{0, -1, 0};  // unit length
};

class OrbitCamera {
 public:
  // Starts exactly at start.camera. It orbits start.center, which stays where it is in the image;
  // where it is not in that camera's image, a point on its axis.
  explicit OrbitCamera(const StartView& start);

  // Radians. Positive: the camera moves to its right and upwards, without reaching the poles.
  void Orbit(float right, float upwards);
  // Moves the image content by these fractions of the image height.
  void Pan(float right, float down);
  // Each step reduces the distance by a tenth.
  void Zoom(float steps);
  void Reset();

  // At the start's size, and until it is moved, this is start.camera up to rounding; at another
  // size, it shows that whole image and what lies beside it.
  Camera At(int width, int height) const;

 private:
  struct Pose {
    math::Mat3<float> cam_from_world;
    math::Vec3<float> target;  // the point that is orbited
    float distance;            // its depth in the camera, > 0
  };

  Camera lens_;
  math::Vec3<float> up_;
  math::Vec3<float> ray_{0, 0, 1};  // to the target, in the camera's frame, at depth 1
  Pose home_, pose_;
};

// `lens` at `eye`, looking along `forward` (unit), with `up` upwards in the image.
Camera Looking(Camera lens,
               const math::Vec3<float>& eye,
               const math::Vec3<float>& forward,
               const math::Vec3<float>& up);

// Initial views: in front of a head, at a training camera, or with splats filling the image.
//
// Frontal view. vertices: [V, 3] of the posed head, metres; root: axis-angle of its root joint.
StartView BeforeHead(const std::vector<float>& vertices, const std::array<float, 3>& root);

// The first of a scene's cameras (at least one); the centre is the point that all of them look at.
StartView AtCamera(const std::vector<Camera>& cameras);

// Frames most of the visible splats, ignoring stray ones; y down, as in most 3DGS files. Throws
// Error naming `file` if no splat is visible.
StartView BeforeSplats(const std::string& file, const Gaussians& gaussians);

}  // namespace cosplat::viewer

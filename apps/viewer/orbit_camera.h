// The camera that the mouse moves: it looks at a point, circles it, shifts and nears it.
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

// Where the viewer begins. World units.
struct StartView {
  Camera camera;
  std::array<float, 3> center{};      // what it looks at, roughly
  std::array<float, 3> up{0, -1, 0};  // unit length
};

class OrbitCamera {
 public:
  // Begins exactly at start.camera. It circles the point of that camera's axis that is nearest to
  // start.center.
  explicit OrbitCamera(const StartView& start);

  // Radians. Positive: the camera goes to its right and upwards, short of the poles.
  void Orbit(float right, float upwards);
  // Shares of the image's height by which what is seen moves.
  void Pan(float right, float down);
  // Each step brings it a tenth nearer.
  void Zoom(float steps);
  void Reset();

  // At the start's size, until it is moved, start.camera to rounding; at another its whole image
  // and what lies beside it.
  Camera At(int width, int height) const;

 private:
  struct Pose {
    math::Mat3<float> cam_from_world;
    math::Vec3<float> target;  // on the camera's axis
    float distance;            // of the camera from it, > 0
  };

  Camera lens_;
  math::Vec3<float> up_;
  Pose home_, pose_;
};

// Where to stand at first: before a head, at a training camera, or so that splats fill the image.

// From the front. vertices: [V, 3] of the posed head, metres; root: axis-angle of its root joint.
StartView BeforeHead(const std::vector<float>& vertices, const std::array<float, 3>& root);

// At the first of a scene's cameras (at least one); the centre is what all of them look at.
StartView AtCamera(const std::vector<Camera>& cameras);

// So that most of what is seen of the splats is in the image, whatever floats around it; y down,
// as 3DGS's files mostly have it. Throws Error naming `file` when none is to be seen.
StartView BeforeSplats(const std::string& file, const Gaussians& gaussians);

}  // namespace cosplat::viewer

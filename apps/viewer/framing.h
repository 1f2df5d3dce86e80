// Where to stand at first: before a head, at a training camera, or so that splats fill the picture.
#pragma once

#include <vector>

#include "apps/viewer/orbit_camera.h"
#include "flame/model.h"
#include "splat/gaussians.h"

namespace cosplat::viewer {

// From the front. vertices: [V, 3] of the posed head, metres; root: axis-angle of its root joint.
StartView BeforeHead(const std::vector<float>& vertices, const std::array<float, 3>& root);

// At the first of a scene's cameras (at least one); the centre is what all of them look at.
StartView AtCamera(const std::vector<Camera>& cameras);

// So that most of what is seen of the splats is in the picture, whatever floats around it; y down,
// as 3DGS's files mostly have it. Throws Error naming `file` when none is to be seen.
StartView BeforeSplats(const std::string& file, const Gaussians& gaussians);

}  // namespace cosplat::viewer

// cameras.json of a model folder, as viewers of 3DGS models read it.
#pragma once

#include <string>
#include <vector>

#include "splat/base/camera.h"

namespace cosplat {

struct NamedCamera {
  std::string name;
  Camera camera;
};

// An array of {id, img_name, width, height, position (world), rotation (world_from_cam, rows), fy,
// fx}; ids count from 0. Atomic; throws Error.
void WriteCamerasJson(const std::string& path, const std::vector<NamedCamera>& cameras);

// Principal points, which the file does not store, are assumed at the image centres. Throws Error
// naming file and field.
std::vector<NamedCamera> ReadCamerasJson(const std::string& path);

}  // namespace cosplat

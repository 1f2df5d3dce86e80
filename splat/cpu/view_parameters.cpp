#include "splat/cpu/view_parameters.h"

#include <array>

#include "splat/basis_constants.h"

namespace cosplat {

ViewParameters ViewOfCamera(const Camera& camera, Basis basis, int degree) {
  ViewParameters v{};
  for (int i = 0; i < 9; ++i) v.rotation[i] = camera.rotation[i];
  const std::array<float, 3> center = camera.Center();
  for (int i = 0; i < 3; ++i) {
    v.translation[i] = camera.translation[i];
    v.center[i] = center[i];
  }
  v.fx = camera.fx;
  v.fy = camera.fy;
  v.cx = camera.cx;
  v.cy = camera.cy;
  v.width = float(camera.width);
  v.height = float(camera.height);
  v.basis_constants = BasisConstants(basis);
  v.folds_direction = FoldsDirection(basis);
  v.degree = degree;
  return v;
}

}  // namespace cosplat

#include "avatar/plugin/splats.h"

#include <algorithm>

#include "avatar/plugin/boundary.h"

namespace cosplat::plugin {

void WriteSplats(const WorldGaussians& gaussians,
                 Basis basis,
                 int degree,
                 const Camera& camera,
                 float blur_variance,
                 ViewSplats& memory,
                 cosplat_splats& out) {
  FillViewSplats(gaussians, basis, camera, degree, blur_variance, memory);
  const cosplat_camera seen = FromCamera(camera);
  out.width = seen.width;
  out.height = seen.height;
  out.fx = seen.fx;
  out.fy = seen.fy;
  out.cx = seen.cx;
  out.cy = seen.cy;
  std::copy_n(seen.cam_from_world, 12, out.cam_from_world);
  out.count = uint32_t(gaussians.count);
  out.centers = memory.centers.data();
  out.colors = memory.colors.data();
  out.scales = memory.scales.data();
  out.rotations = memory.rotations.data();
}

}  // namespace cosplat::plugin

using namespace cosplat::plugin;  // NOLINT: the C interface lies outside that namespace

cosplat_status cosplat_get_splats(cosplat_avatar* avatar,
                                  float blur_variance,
                                  cosplat_splats* splats) {
  static cosplat::ViewSplats memory;  // a module is one worker's, which has one avatar
  return WithAvatar(avatar, [&](Instance& instance) {
    if (!instance.camera()) throw CodedError(COSPLAT_ERROR_NOT_FOUND, "camera", "none is set");
    const cosplat::Gaussians& gaussians = instance.avatar().gaussians;
    WriteSplats(instance.Placed(),
                gaussians.basis,
                gaussians.degree,
                *instance.camera(),
                blur_variance,
                memory,
                *splats);
  });
}

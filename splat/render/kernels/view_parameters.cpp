#include "splat/render/kernels/view_parameters.h"

#include <array>
#include <string>

#include "splat/base/error.h"
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

void CheckArguments(const WorldGaussians& gaussians,
                    const Camera& camera,
                    const RenderSettings& settings) {
  if (camera.width < 1 || camera.height < 1)
    throw Error("camera", "image of " + SizeText(camera.width, camera.height) + " pixels");
  if (3 * (CoefficientCount(settings.degree) - 1) > gaussians.rest_width ||
      settings.degree > kMaxTrainedDegree)
    throw Error("degree", std::to_string(settings.degree) + " is more than is stored");
  if (settings.exp_degree < kMinExpDegree || settings.exp_degree > kMaxExpDegree)
    throw Error("exp_degree",
                std::to_string(settings.exp_degree) + " is not from " +
                    std::to_string(kMinExpDegree) + " to " + std::to_string(kMaxExpDegree));
}

}  // namespace cosplat

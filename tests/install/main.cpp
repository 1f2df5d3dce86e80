// Renders one opaque red Gaussian in front of the camera and looks at the middle of the picture.
#include <cmath>
#include <cstdio>

#include "splat/basis_constants.h"
#include "splat/rasterizer.h"

int main() {
  using namespace cosplat;
  Gaussians g;
  g.Resize(1);
  g.at(kPosition, 0)[2] = 2;
  g.at(kRotation, 0)[0] = 1;
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, 0)[k] = std::log(0.2f);
  g.at(kOpacityLogit, 0)[0] = 20;
  g.at(kColorDc, 0)[0] = 0.5f / BasisConstants(g.basis)[0];
  for (int k = 1; k < 3; ++k) g.at(kColorDc, 0)[k] = -0.5f / BasisConstants(g.basis)[0];

  Camera camera;
  camera.width = camera.height = 33;
  camera.fx = camera.fy = 40;
  camera.cx = camera.cy = 16.5f;
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(ViewOf(g), g.basis, camera, RenderSettings{}, image, *tape);

  const size_t plane = 33 * 33, middle = 16 * 33 + 16;
  const float red = image.color[middle], green = image.color[plane + middle];
  std::printf("red %.3f green %.3f alpha %.3f\n", red, green, 1 - image.transmittance[middle]);
  // The cap on alpha is 0.99.
  return std::fabs(red - 0.99f) < 1e-3f && std::fabs(green) < 1e-3f ? 0 : 1;
}

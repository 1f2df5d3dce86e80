// What a program that only plays does: makes an avatar of one Gaussian on the made head, and looks
// at the pixel where it must be.
#include <cmath>
#include <cstdio>

#include "assets/head/procedural_head.h"
#include "avatar/play/player.h"
#include "splat/basis_constants.h"

int main() {
  using namespace cosplat;
  const FlameModel head = MakeProceduralHead();
  AvatarModel avatar;
  avatar.mesh = {head.template_vertices, head.faces};
  avatar.embedding.triangle = {0};
  avatar.embedding.barycentric = {{1.0f, 0.0f}};  // the triangle's first vertex
  Gaussians& g = avatar.gaussians;
  g.Resize(1);
  g.at(kRotation, 0)[0] = 1;
  for (int k = 0; k < 3; ++k) g.at(kScaleLog, 0)[k] = std::log(0.02f);
  g.at(kOpacityLogit, 0)[0] = 20;
  const float half = 0.5f / BasisConstants(g.basis)[0];
  for (int k = 0; k < 3; ++k) g.at(kColorDc, 0)[k] = k == 0 ? half : -half;  // red

  Camera camera;
  camera.width = camera.height = 33;
  camera.fx = camera.fy = 40;
  camera.cx = camera.cy = 16.5f;
  const float* p = &avatar.mesh.vertices[3 * avatar.mesh.faces[0][0]];
  camera.translation = {-p[0], -p[1], 0.5f - p[2]};

  Player player(avatar, head);
  const Image8 image = player.Render(FlameParams(), camera);
  const uint8_t* middle = &image.data[4 * (16 * 33 + 16)];
  std::printf("red %d green %d alpha %d\n", middle[0], middle[1], middle[3]);
  // Straight alpha, capped at 0.99.
  return middle[0] >= 254 && middle[1] <= 1 && middle[3] == 252 ? 0 : 1;
}

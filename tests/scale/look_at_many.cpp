// cosplat_look_at_many SPLATS COPIES [FOLDER]: how fast and how well a scene of millions of
// Gaussians is looked at. Stands COPIES of a file of splats (-y up) on a square, makes levels of
// detail of them, and flies from far outside to their middle, at 1920 x 1080. Prints, for limits on
// the time of an image and for none: images per second while moving, the slowest of them, Gaussians
// per image, and PSNR against all Gaussians. Writes the first and the last image at 60 ms and the
// first one of all Gaussians into FOLDER.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/io/splat_file.h"
#include "splat/levels/frame_budget.h"
#include "splat/levels/level_renderer.h"
#include "splat/media/image_io.h"
#include "splat/train/loss/loss.h"

namespace cosplat {
namespace {

constexpr int kWidth = 1920, kHeight = 1080, kImages = 120, kCompared = 8;

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Crowd {
  Gaussians scene;
  float side = 0;    // of the square, world units
  float height = 0;  // of one copy
};

Crowd StandOnASquare(const Gaussians& one, int copies) {
  std::array<std::vector<float>, 3> at;
  for (size_t i = 0; i < one.size(); ++i)
    for (size_t k = 0; k < 3; ++k) at[k].push_back(one.at(kPosition, i)[k]);
  std::array<float, 3> low, high;
  for (size_t k = 0; k < 3; ++k) {  // but for strays
    std::sort(at[k].begin(), at[k].end());
    low[k] = at[k][at[k].size() / 1000];
    high[k] = at[k][at[k].size() - 1 - at[k].size() / 1000];
  }
  const int across = int(std::ceil(std::sqrt(double(copies))));
  const float step = 1.2f * std::max(high[0] - low[0], high[2] - low[2]);
  Crowd crowd;
  crowd.side = step * float(across);
  crowd.height = high[1] - low[1];
  crowd.scene.degree = one.degree;
  crowd.scene.basis = one.basis;
  crowd.scene.antialiased = one.antialiased;
  crowd.scene.Resize(size_t(copies) * one.size());
  for (int c = 0; c < copies; ++c) {
    const float x = (float(c % across) + 0.5f) * step - 0.5f * crowd.side;
    const float z = (float(c / across) + 0.5f) * step - 0.5f * crowd.side;
    for (int a = 0; a < kAttributeCount; ++a)
      std::copy(one.values[a].begin(),
                one.values[a].end(),
                crowd.scene.values[a].begin() + long(size_t(c) * one.values[a].size()));
    for (size_t i = size_t(c) * one.size(); i < size_t(c + 1) * one.size(); ++i) {
      float* p = crowd.scene.at(kPosition, i);
      p[0] += x - 0.5f * (low[0] + high[0]);
      p[1] -= high[1];  // feet at 0
      p[2] += z - 0.5f * (low[2] + high[2]);
    }
  }
  return crowd;
}

// On a spiral about the crowd, from `t` = 0 far outside to 1 in its midst.
Camera CameraAt(const Crowd& crowd, float t) {
  const float angle = 2.2f * t, radius = crowd.side * (1.6f - 1.45f * t);
  const float up = crowd.height * (0.7f + 3 * (1 - t));
  const std::array<float, 3> from{radius * std::sin(angle), -up, -radius * std::cos(angle)};
  const std::array<float, 3> to{0, -0.4f * crowd.height, 0};
  std::array<float, 3> z, x, y;
  float length = 0;
  for (size_t k = 0; k < 3; ++k) length += (to[k] - from[k]) * (to[k] - from[k]);
  for (size_t k = 0; k < 3; ++k) z[k] = (to[k] - from[k]) / std::sqrt(length);
  const float flat = std::hypot(z[0], z[2]);
  x = {z[2] / flat, 0, -z[0] / flat};  // y of the world points down
  y = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
  Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = camera.fy = 1.2f * kHeight;
  camera.cx = 0.5f * kWidth;
  camera.cy = 0.5f * kHeight;
  for (size_t k = 0; k < 3; ++k) {
    camera.rotation[k] = x[k];
    camera.rotation[3 + k] = y[k];
    camera.rotation[6 + k] = z[k];
  }
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) camera.translation[i] -= camera.rotation[3 * i + k] * from[k];
  return camera;
}

float TimeOf(int image) { return float(image) / float(kImages - 1); }

void LookAtMany(const std::string& file, int copies, const std::string& folder) {
  const auto keep = [&](const char* name, const RenderedImage& image) {
    if (!folder.empty()) WriteImage(folder + name, ToBytes(image.ToImage()));
  };
  Crowd crowd = StandOnASquare(ReadSplats(file), copies);
  const RenderSettings settings{{1, 1, 1}, crowd.scene.degree};
  std::printf("%zu Gaussians\n", crowd.scene.size());
  std::vector<RenderedImage> all(kCompared);
  double seconds = 0;
  {
    const auto rasterizer = MakeCpuRasterizer();
    const auto tape = rasterizer->MakeTape(false);
    for (int i = 0; i < kCompared; ++i) {
      const Camera camera = CameraAt(crowd, TimeOf(i * (kImages - 1) / (kCompared - 1)));
      const double start = Now();
      rasterizer->Forward(
          ViewOf(crowd.scene), crowd.scene.basis, camera, settings, all[size_t(i)], *tape);
      seconds += Now() - start;
    }
  }
  keep("/far_all.png", all[0]);
  std::printf("all of them: %.2f images/s\n", kCompared / seconds);
  const double start = Now();
  LevelRenderer renderer(BuildLevels(std::move(crowd.scene)));
  std::printf("levels made in %.1f s\n\n", Now() - start);
  std::printf("| limit | images/s | slowest | Gaussians | copied per image | PSNR |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const double limit : {20.0, 40.0, 60.0, 500.0, 1e9}) {
    FrameBudget budget(limit);
    double moving = 0, slowest = 0, psnr = 0;
    size_t drawn = 0, copied = 0;
    RenderedImage image;
    for (int i = 0; i < kImages; ++i) {
      const Camera camera = CameraAt(crowd, TimeOf(i));
      LevelLimits limits;
      if (limit < 1e9) limits.max = budget.max();
      const double begun = Now();
      renderer.Draw(camera, settings, limits, image);
      const double took = Now() - begun;
      budget.Drawn(renderer.drawn(), 1000 * took);
      moving += took;
      if (i > 0) slowest = std::max(slowest, took);
      drawn += renderer.drawn();
      copied += renderer.copied();
      for (int k = 0; k < kCompared; ++k)
        if (k * (kImages - 1) / (kCompared - 1) == i)
          psnr += Psnr(image.color, all[size_t(k)].color) / kCompared;
      if (limit == 60 && i == 0) keep("/far.png", image);
    }
    if (limit == 60) keep("/near.png", image);
    std::printf(limit < 1e9 ? "| %.0f ms " : "| none ", limit);
    std::printf("| %.1f | %.0f ms | %zu | %zu | %.2f dB |\n",
                kImages / moving,
                1000 * slowest,
                drawn / kImages,
                copied / kImages,
                psnr);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace cosplat

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fprintf(stderr, "usage: cosplat_look_at_many SPLATS COPIES [FOLDER]\n");
    return 2;
  }
  try {
    cosplat::LookAtMany(argv[1], std::max(1, std::atoi(argv[2])), argc > 3 ? argv[3] : "");
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "cosplat_look_at_many: %s\n", problem.what());
    return 1;
  }
}

#include "apps/cosplat/run/turned_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "apps/cosplat/run/camera_path.h"
#include "avatar/surface/silhouette.h"
#include "flame/pose.h"
#include "splat/base/text.h"
#include "splat/math/vec.h"
#include "splat/media/image_io.h"
#include "splat/media/signed_distance.h"

namespace cosplat {
namespace {

constexpr std::array<float, 12> kAngles{0, -15, -30, -45, -60, -90, 180, 15, 30, 45, 60, 90};
constexpr int kColumns = 6;
constexpr int kCell = 320;               // px, width of a view in the sheet
constexpr double kWithinInFront = 0.99;  // of the alpha, which says how far hair and clothes reach

// [height, width] px from the mesh's outline, positive outside.
Image FromMesh(const std::vector<float>& vertices, Player& player, const Camera& camera) {
  Image8 mask(camera.width, camera.height, 1);
  const std::vector<uint8_t> covered = MeshSilhouette(vertices, player.avatar().mesh.faces, camera);
  for (size_t i = 0; i < mask.pixels(); ++i) mask.data[i] = covered[i] ? 255 : 0;
  return SignedDistance(mask, 128);
}

double Alpha(const Image8& rgba, size_t pixel) { return rgba.data[4 * pixel + 3]; }

// px; kWithinInFront of the alpha are not farther from the mesh.
int ReachOf(const Image8& rgba, const Image& distance) {
  std::vector<double> at(size_t(rgba.width + rgba.height), 0);  // by distance, rounded up
  double left = 0;
  for (size_t i = 0; i < rgba.pixels(); ++i) {
    const float d = std::clamp(std::ceil(distance.data[i]), 0.0f, float(at.size() - 1));
    at[size_t(d)] += Alpha(rgba, i);
    left += Alpha(rgba, i);
  }
  const double most = (1 - kWithinInFront) * left;
  size_t reach = 0;
  while (reach + 1 < at.size() && (left -= at[reach]) > most) ++reach;
  return int(reach);
}

double ShareBeyond(const Image8& rgba, const Image& distance, int reach) {
  double beyond = 0, all = 0;
  for (size_t i = 0; i < rgba.pixels(); ++i) {
    all += Alpha(rgba, i);
    if (distance.data[i] > float(reach)) beyond += Alpha(rgba, i);
  }
  return all > 0 ? beyond / all : 0;
}

void Paste(const Image8& rgba, const std::array<float, 3>& background, size_t cell, Image8& sheet) {
  const int height = std::max(1, rgba.height * kCell / rgba.width);
  const Image8 small = ResizeByArea(rgba, kCell, height);
  const int left = int(cell) % kColumns * kCell, top = int(cell) / kColumns * height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < kCell; ++x)
      for (int c = 0; c < 3; ++c) {
        const float alpha = small.at(x, y, 3) / 255.0f;
        const float value = alpha * small.at(x, y, c) + (1 - alpha) * 255 * background[size_t(c)];
        sheet.at(left + x, top + y, c) = uint8_t(std::lround(std::clamp(value, 0.0f, 255.0f)));
      }
}

}  // namespace

TurnedSheet DrawTurned(Player& player,
                       const FlameModel& flame,
                       const FlameParams& rest,
                       const Camera& lens,
                       const std::array<float, 3>& background) {
  PosedAvatar placed;
  player.Pose(rest, placed);
  const std::vector<float> vertices = player.VerticesOf(placed);
  std::array<float, 3> center{};
  for (int v = 0; v < flame.vertex_count; ++v)
    for (size_t k = 0; k < 3; ++k)
      center[k] += vertices[3 * size_t(v) + k] / float(flame.vertex_count);
  const std::array<float, 3> up{-lens.rotation[3], -lens.rotation[4], -lens.rotation[5]};
  // From the camera to before the face: the first of several cameras may stand aside.
  const math::Vec3<float> axis = math::ToVec3(up), forward = HeadForward(rest),
                          arm = math::ToVec3(lens.Center()) - math::ToVec3(center);
  const auto level = [&](const math::Vec3<float>& v) { return v - axis * math::Dot(axis, v); };
  const float to_face = std::atan2(math::Dot(axis, math::Cross(arm, forward)),
                                   math::Dot(level(arm), level(forward))) *
                        180 / std::numbers::pi_v<float>;
  TurnedSheet sheet;
  const int rows = (int(kAngles.size()) + kColumns - 1) / kColumns;
  sheet.image = Image8(kColumns * kCell, rows * std::max(1, lens.height * kCell / lens.width), 3);
  int reach = 0;
  for (const float degrees : kAngles) {
    const Camera camera = TurnedAround(lens, center, up, to_face + degrees);
    Image8 image;
    player.Render(rest, camera, image);
    const Image distance = FromMesh(vertices, player, camera);
    if (degrees == 0) reach = ReachOf(image, distance);
    Paste(image, background, sheet.views.size(), sheet.image);
    sheet.views.push_back({degrees, ShareBeyond(image, distance, reach)});
  }
  return sheet;
}

std::string ToString(const TurnedSheet& sheet) {
  std::string text;
  for (const TurnedView& view : sheet.views)
    text +=
        Format("{}{:.0f} deg {:.2f} %", text.empty() ? "" : ", ", view.degrees, 100 * view.outside);
  return text;
}

}  // namespace cosplat

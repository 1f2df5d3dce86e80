#include "apps/cosplat/run/turned_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/cosplat/run/camera_path.h"
#include "avatar/surface/silhouette.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"

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
  bool some = false, all = true;
  for (size_t i = 0; i < mask.pixels(); ++i) {
    mask.data[i] = covered[i] ? 255 : 0;
    some = some || covered[i];
    all = all && covered[i];
  }
  if (some && !all) return SignedDistance(mask, 128);
  return Image(camera.width, camera.height, 1, some ? -1e9f : 1e9f);
}

double Sum(const Image8& rgba) {
  double sum = 0;
  for (size_t i = 0; i < rgba.pixels(); ++i) sum += rgba.data[4 * i + 3];
  return sum;
}

double Beyond(const Image8& rgba, const Image& distance, float limit) {
  double sum = 0;
  for (size_t i = 0; i < rgba.pixels(); ++i)
    if (distance.data[i] > limit) sum += rgba.data[4 * i + 3];
  return sum / std::max(Sum(rgba), 1.0);
}

// Within which kWithinInFront of the alpha are, px.
float ReachOf(const Image8& rgba, const Image& distance) {
  float reach = 0;
  while (reach < float(rgba.width) && Beyond(rgba, distance, reach) > 1 - kWithinInFront) ++reach;
  return reach;
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
                       const Camera& front,
                       const std::array<float, 3>& background) {
  PosedAvatar placed;
  player.Pose(rest, placed);
  const std::vector<float> vertices = player.VerticesOf(placed);
  std::array<float, 3> center{};
  for (int v = 0; v < flame.vertex_count; ++v)
    for (size_t k = 0; k < 3; ++k)
      center[k] += vertices[3 * size_t(v) + k] / float(flame.vertex_count);
  const std::array<float, 3> up{-front.rotation[3], -front.rotation[4], -front.rotation[5]};
  TurnedSheet sheet;
  const int rows = (int(kAngles.size()) + kColumns - 1) / kColumns;
  sheet.image = Image8(kColumns * kCell, rows * std::max(1, front.height * kCell / front.width), 3);
  float reach = 0;
  for (const float degrees : kAngles) {
    const Camera camera = degrees == 0 ? front : TurnedAround(front, center, up, degrees);
    Image8 image;
    player.Render(rest, camera, image);
    const Image distance = FromMesh(vertices, player, camera);
    if (degrees == 0) reach = ReachOf(image, distance);
    Paste(image, background, sheet.views.size(), sheet.image);
    sheet.views.push_back({degrees, Beyond(image, distance, reach)});
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

#include "apps/cosplat/run/overlay.h"

#include <algorithm>
#include <cmath>

#include "apps/charts/svg_drawing.h"
#include "apps/cosplat/run/html_page.h"
#include "apps/viewer/mesh_view.h"
#include "splat/media/image_glance.h"

namespace cosplat {
namespace {

constexpr int kShownWidth = 480;  // px
constexpr viewer::Rgb kMeshColor{150, 170, 210};
constexpr int kDarkened = 3;  // photographs under points, to a third

}  // namespace

void DrawDot(double x, double y, const std::array<uint8_t, 3>& color, Image8& image) {
  const int radius = std::max(1, image.width / 400);
  for (int dy = -radius; dy <= radius; ++dy)
    for (int dx = -radius; dx <= radius; ++dx) {
      const int px = int(std::floor(x)) + dx, py = int(std::floor(y)) + dy;
      if (dx * dx + dy * dy > radius * radius) continue;
      if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
      for (int c = 0; c < 3; ++c) image.at(px, py, c) = color[size_t(c)];
    }
}

Image8 MeshOver(const std::vector<float>& vertices,
                const std::vector<std::array<int32_t, 3>>& faces,
                const Camera& camera,
                const Image8& image) {
  viewer::SurfaceBuffer buffer;
  buffer.Clear(image.width, image.height);
  viewer::MeshPaint paint;
  paint.faces.assign(faces.size(), kMeshColor);
  viewer::DrawMesh(vertices, faces, paint, camera, buffer);
  Image8 mesh;
  viewer::Resolve(buffer, nullptr, mesh);
  Image8 overlay = image;
  for (size_t i = 0; i < image.pixels(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const int alpha = mesh.data[4 * i + 3] / 2;
      uint8_t& value = overlay.data[3 * i + c];
      value = uint8_t((value * (255 - alpha) + mesh.data[4 * i + c] * alpha) / 255);
    }
  return overlay;
}

Image8 PointsOver(const SceneData& scene, const Camera& camera, const Image8& image) {
  Image8 overlay = image;
  for (uint8_t& value : overlay.data) value /= kDarkened;
  for (size_t i = 0; 3 * i + 2 < scene.points.size(); ++i) {
    const Sighting seen = Sight(camera, &scene.points[3 * i]);
    const uint8_t* color = &scene.point_colors[3 * i];
    if (seen.inside) DrawDot(seen.x, seen.y, {color[0], color[1], color[2]}, overlay);
  }
  return overlay;
}

std::string FigureHtml(const Image8& image, const std::string& caption) {
  const bool large = image.width > kShownWidth;
  const Image8 shown =
      large
          ? ResizeByArea(image, kShownWidth, std::max(1, image.height * kShownWidth / image.width))
          : image;
  return "<figure><img src='" + ImageUri(shown, ".jpg") + "'><figcaption>" + EscapeXml(caption) +
         "</figcaption></figure>";
}

}  // namespace cosplat

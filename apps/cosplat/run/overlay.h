// What a data set says, drawn over its images: for people to see whether both agree.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "splat/io/dataset.h"

namespace cosplat {

// Images are RGB, of the camera's size.

// An image with the mesh half over it, shaded. vertices:
// [V, 3], world units.
Image8 MeshOver(const std::vector<float>& vertices,
                const std::vector<std::array<int32_t, 3>>& faces,
                const Camera& camera,
                const Image8& image);

// The image, darkened, with the scene's points in their colours where the camera sees them.
Image8 PointsOver(const SceneData& scene, const Camera& camera, const Image8& image);

// A dot of a size that is seen when the image is shown small. x, y: px.
void DrawDot(double x, double y, const std::array<uint8_t, 3>& color, Image8& image);

// A figure of a page, reduced to a width that pages show, with its caption.
std::string FigureHtml(const Image8& image, const std::string& caption);

}  // namespace cosplat

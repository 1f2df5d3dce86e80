// Ways in which the viewer shows a model.
#pragma once

#include <array>
#include <string>

namespace cosplat::viewer {

enum class View { kSplats, kEllipsoids, kTriangles, kWire };
constexpr int kViewCount = 4;
constexpr std::array<const char*, kViewCount> kViewNames{
    "splats", "ellipsoids", "triangles", "wire"};  // in the order of View

// Triangles and wire show the mesh, which scenes do not have.
constexpr bool NeedsMesh(View view) { return view == View::kTriangles || view == View::kWire; }

// Throws Error, naming `field`, if `text` is none of the names.
View ViewFromString(const std::string& text, const std::string& field);

}  // namespace cosplat::viewer

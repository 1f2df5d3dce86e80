// Whether a scene's images show what its cameras and points say: the part of CheckScene
// (splat/io/scene_check.h) that tries how else they could have been meant.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "splat/base/skipped.h"
#include "splat/io/dataset.h"
#include "splat/media/image_glance.h"

namespace cosplat {

// A view and its image, reduced.
struct LookedAt {
  const SceneView* view = nullptr;
  Image8 image;
  Camera camera;  // at that size
  Glance glance{};
  double ignored = -1;  // share of the image that its mask ignores; negative without a mask
  size_t group = 0;     // neighbours in `views` are of one group
};

// Groups of three neighbours, 24 views in all, less those whose image cannot be used.
std::vector<LookedAt> LookAt(const std::vector<const SceneView*>& views,
                             std::vector<SkippedFrame>& skipped);

// Adds what it finds.
void CheckFit(const SceneData& scene,
              const std::vector<LookedAt>& looked,
              std::vector<Finding>& findings);

// Its two parts: by the colours of points, and by the silhouettes of renderings with alpha.
void CheckColors(const SceneData& scene,
                 const std::vector<LookedAt>& looked,
                 std::vector<Finding>& findings);
void CheckSilhouettes(const std::vector<LookedAt>& looked, std::vector<Finding>& findings);

// How a view could have been meant instead.
struct Reading {
  bool mirror_x = false, mirror_y = false;  // of the image
  float focal = 1;                          // factor
  bool other_axes = false;                  // y and z of the camera reversed
  bool inverted = false;                    // world_from_cam in place of cam_from_world
  const char* what = "";
  float dx = 0, dy = 0;  // added to the place in the image, in shares of its sides
};
inline const Reading kReadings[] = {
    {true, false, 1, false, false, "images mirrored left to right"},
    {false, true, 1, false, false, "images mirrored top to bottom"},
    {true, true, 1, false, false, "images turned upside down"},
    {false, false, 0.7f, false, false, "a focal length of 0.7 times the given one"},
    {false, false, 1.4f, false, false, "a focal length of 1.4 times the given one"},
    {false, false, 0.5f, false, false, "a focal length of half the given one"},
    {false, false, 2, false, false, "a focal length of twice the given one"},
    {false, false, 1, true, false, "camera axes of the other convention (OpenGL, OpenCV)"},
    {false, false, 1, false, true, "poses inverted (world to camera, camera to world)"},
};

// The camera that it would have been. Of a mirrored image the focal length is negative.
Camera ReadAs(Camera camera, const Reading& how);

// Where in its image the camera sees the point: shares of width and height; none if it does not.
std::optional<std::array<float, 2>> PlaceOf(const Camera& camera, const float* point);

// Which of `count` cells a share of the whole lies in.
inline int CellOf(float share, int count) {
  return std::clamp(int(share * float(count)), 0, count - 1);
}

}  // namespace cosplat

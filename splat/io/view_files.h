// What all scene layouts share: finding a view's image and fixing the camera that shows it.
#pragma once

#include <string>

#include "splat/io/dataset.h"

namespace cosplat {

// An image at 1/resolution, or the means to make it.
struct FoundImage {
  std::string path;            // empty: there is none
  int divide_by = 1;           // what is left to do after the folder's own reduction
  std::string tried;           // the path that was looked for, for messages
  bool folder_exists = false;  // some folder that fits is there
};

// Looks for folder_<resolution>/name, then folder/name, then folder_<k>/name with the greatest k
// that divides `resolution`. Whole folders are chosen, never single files: all views come from one.
FoundImage FindImage(const std::string& folder, const std::string& name, int resolution);

// Completes `view` (whose image_path, pose and distortion are set): scales `lens` (intrinsics at
// the size for which they were measured) to the image file, finds the pinhole that replaces a
// distorted lens, and divides the size by `divide_by` (rounded). Throws Error when the file's
// proportions differ from the camera's by more than a pixel.
void FinishView(const Camera& lens, int divide_by, SceneView& view);

// The pinhole of the same size, principal point and fx : fy that shows as much as possible of a
// distorted image while every pixel is covered by it: found by bisection over the focal length,
// tracing the border. Half the field of view is kept below atan(2): beyond, a flat image spends
// its pixels on the rim. Throws Error(file, ...) when no such camera exists.
Camera PinholeInside(const std::string& file, const Camera& lens, const Distortion& distortion);

// One function per layout of scene data. Each fills layout, points and skipped, and puts views into
// `train` (and `test` where the data has its own split); LoadScene splits and checks.

// <path>/sparse/0 or <path>/sparse, with images in <path>/images or images_N.
bool IsColmapScene(const std::string& path);
void LoadColmapScene(const std::string& path, const SceneOptions& options, SceneData& scene);

// <path>/transforms_train.json and, where present, transforms_test.json.
bool IsBlenderScene(const std::string& path);
void LoadBlenderScene(const std::string& path, const SceneOptions& options, SceneData& scene);

// <path>/transforms.json of nerfstudio or instant-ngp.
bool IsNerfstudioScene(const std::string& path);
void LoadNerfstudioScene(const std::string& path, const SceneOptions& options, SceneData& scene);

}  // namespace cosplat

// Shared by all scene layouts: finding a view's image and setting its camera.
#pragma once

#include <string>

#include "splat/base/data_files.h"
#include "splat/io/dataset.h"

namespace cosplat {

// An image at 1/resolution, or one from which to make it.
struct FoundImage {
  std::string path;        // empty: not found
  int divide_by = 1;       // remaining reduction, after the folder's own
  std::string tried;       // the path searched, for messages
  bool elsewhere = false;  // folder_<resolution> exists, but does not have it
};

// Looks for folder_<resolution>/name, then folder/name, then folder_<k>/name with the greatest k
// that divides `resolution`, among the data set's files.
FoundImage FindInFolder(DataFiles& files,
                        const std::string& folder,
                        const std::string& name,
                        int resolution);
// The same of folder/name in one.
FoundImage FindImage(DataFiles& files, const std::string& named, int resolution);

// Points of the first of these PLY files that is there, with a note, if the scene has none.
void FindPoints(const std::vector<std::string>& files, SceneData& scene);

// What is said of images that a folder of reduced ones lacks.
void NoteElsewhere(size_t count, int resolution, SceneData& scene);

// Completes `view` (whose image_path, pose and distortion are set): scales `lens` (intrinsics at
// the size for which they were measured) to the image file, finds the pinhole camera that replaces
// a distorted lens, and divides the size by `divide_by` (rounded). Throws Error if the file's
// aspect ratio differs from the camera's by more than a pixel.
void FinishView(const Camera& lens, int divide_by, SceneView& view);

// Decides by the points' colours whether images with a `tag` are turned, and notes it.
void SettleHalfTurns(SceneData& scene);

// The pinhole camera of the same size, principal point and fx : fy with the largest field of view
// for which the distorted image covers every pixel: found by bisection over the focal length,
// tracing the border. Half the field of view is kept below atan(2), beyond which a planar image
// spends its pixels on the rim. Throws Error(file, ...) if no such camera exists.
Camera PinholeInside(const std::string& file, const Camera& lens, const Distortion& distortion);

// Makes the scene's coordinates floats: counted from `origin`, or where there is none from one that
// is chosen by all views and points, read_points as `points`, near planes, and the extent.
void PlaceScene(const std::optional<WorldOrigin>& origin, SceneData& scene);

// One function per layout of scene data. Each sets layout, read_points and skipped, and adds views
// with their centres to `train` (and `test` if the data has its own split); LoadScene splits,
// checks and places.

// <path>/sparse/0 or <path>/sparse, with images in <path>/images or images_N.
bool IsColmapScene(const std::string& path);
void LoadColmapScene(const std::string& path, const SceneOptions& options, SceneData& scene);

// <path>/transforms_train.json and, if present, transforms_test.json.
bool IsBlenderScene(const std::string& path);
void LoadBlenderScene(const std::string& path, const SceneOptions& options, SceneData& scene);

// <path>/transforms.json of nerfstudio or instant-ngp.
bool IsNerfstudioScene(const std::string& path);
void LoadNerfstudioScene(const std::string& path, const SceneOptions& options, SceneData& scene);

}  // namespace cosplat

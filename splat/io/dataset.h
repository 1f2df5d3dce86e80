// A static scene's data: images, cameras, split and initial points.
//
// splat/io/{colmap,transforms}*.cpp read the layouts that structure-from-motion programs and
// renderers write into this one structure; the scene trainer and `render` read it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/base/skipped.h"
#include "splat/base/world_frame.h"
#include "splat/media/image_io.h"

namespace cosplat {

struct SceneView {
  std::string name;        // as the data set names the image, without the images folder
  std::string image_path;  // the file that is read
  std::string mask_path;   // empty, or an image that is black where the view's is to be ignored
  Camera camera;           // pinhole, at the size that LoadViewImage returns

  // How that image is made from the file: undistorted from `file_camera` (at the file's size), then
  // resized by area averaging.
  Camera file_camera;
  Distortion distortion;
  int orientation = 1;  // EXIF's, by which the file's image is turned first
  int tag = 1;          // EXIF's of the file, where it keeps the proportions: see SettleHalfTurns
  std::array<double, 3> center{};  // the camera's place as the data set has it
};

struct SceneData {
  std::string source;  // folder as given
  std::string layout;  // "colmap", "blender", "nerfstudio"
  std::vector<SceneView> train;
  std::vector<SceneView> test;
  // All coordinates are counted from here: far from zero only if the data is (PlaceScene).
  WorldOrigin origin{};
  std::vector<float> points;          // [P, 3] world units; empty where the data has none
  std::vector<double> read_points;    // as the data set has them, until LoadScene has placed them
  std::vector<uint8_t> point_colors;  // [P, 3] RGB
  std::vector<SkippedFrame> skipped;  // unusable frames, each with the reason
  std::vector<std::string> notes;     // what a user should know of how it was read
  bool coarse_points = false;         // stored as floats, far from zero: rounded by the data set
  float extent = 1;                   // > 0, world units: see SceneExtent
  bool own_split = false;             // `test` is the data's own
  bool renderings = false;            // with alpha: results are published on white
};

struct SceneOptions {
  int resolution = 1;  // -r: images are divided by this
  bool eval = false;   // every 8th view by name is the test set, where the data has no own split
  // Every 8th of the training views (as with `eval`) becomes the test set and the real test set is
  // dropped: for choosing hyper-parameters without seeing test views.
  bool fold = false;
  std::optional<WorldOrigin> origin{};  // of a run on this data; otherwise chosen from the data
  std::string images = "images";        // COLMAP's layout: the folder of the images
};

// Detects the layout from the files present: sparse/ (COLMAP), transforms_train.json (Blender),
// transforms.json (nerfstudio, instant-ngp). Views are sorted by name. Images come from
// images_<resolution> if that exists and are otherwise resized by area averaging. Masks are those
// that the layout names (mask_path), and masks/NAME.png of the folder, where NAME is the image's
// name with or without its extension, as COLMAP has them. Throws Error naming file, field and
// value; unusable frames are skipped and listed.
//
// Coordinates are counted from an origin near the scene where it lies far from zero, and near
// planes are relative to its size (splat/base/world_frame.h).
SceneData LoadScene(const std::string& path, const SceneOptions& options);

// RGB, or RGBA with straight alpha, of exactly view.camera's size. Throws Error if the file is
// damaged or its size is not view.file_camera's.
Image8 LoadViewImage(const SceneView& view);

// One channel of the same size: 255 where the image is to be ignored, 0 elsewhere. Empty if the
// view has no mask. Throws Error if the file is damaged or its proportions are not
// view.file_camera's.
Image8 LoadIgnored(const SceneView& view);

// 3DGS's cameras_extent: 1.1 times the greatest distance of a camera from their mean; 1 if all
// cameras coincide. Position learning rates and size limits scale with it.
float SceneExtent(const std::vector<SceneView>& views);

}  // namespace cosplat

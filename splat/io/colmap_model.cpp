#include "splat/io/colmap_model.h"

#include <cmath>
#include <cstring>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

using Model = Distortion::Model;

// COLMAP's camera models (its source: sensor/models.h), 12 to 17 of 4.x.
constexpr ColmapModelKind kModels[] = {{0, "SIMPLE_PINHOLE", 3, 1, Model::kNone},
                                       {1, "PINHOLE", 4, 2, Model::kNone},
                                       {2, "SIMPLE_RADIAL", 4, 1, Model::kBrown},
                                       {3, "RADIAL", 5, 1, Model::kBrown},
                                       {4, "OPENCV", 8, 2, Model::kBrown},
                                       {5, "OPENCV_FISHEYE", 8, 2, Model::kFisheye},
                                       {6, "FULL_OPENCV", 12, 2, Model::kBrown},
                                       {7, "FOV", 5, 0, Model::kNone},
                                       {8, "SIMPLE_RADIAL_FISHEYE", 4, 1, Model::kFisheye},
                                       {9, "RADIAL_FISHEYE", 5, 1, Model::kFisheye},
                                       {10, "THIN_PRISM_FISHEYE", 12, 0, Model::kNone},
                                       {11, "RAD_TAN_THIN_PRISM_FISHEYE", 16, 0, Model::kNone},
                                       {12, "SIMPLE_DIVISION", 4, 1, Model::kDivision},
                                       {13, "DIVISION", 5, 2, Model::kDivision},
                                       {14, "SIMPLE_FISHEYE", 3, 1, Model::kFisheye},
                                       {15, "FISHEYE", 4, 2, Model::kFisheye},
                                       {16, "EUCM", 6, 0, Model::kNone},
                                       {17, "EQUIRECTANGULAR", 2, 0, Model::kNone}};
constexpr int kEquirectangular = 17;

const ColmapModelKind* FindByName(const std::string& name) {
  for (const ColmapModelKind& kind : kModels)
    if (name == kind.name) return &kind;
  return nullptr;
}

// Parameters are [f | fx fy] cx cy, then distortion in the order of Distortion; radial models lack
// the tangential terms p1, p2 (OpenCV's third and fourth).
void SetParams(const ColmapModelKind& kind, const std::vector<double>& p, ColmapCamera& camera) {
  const size_t center = size_t(kind.focals);
  camera.lens.fx = float(p[0]);
  camera.lens.fy = float(p[center - 1]);
  camera.lens.cx = float(p[center]);
  camera.lens.cy = float(p[center + 1]);
  bool distorts = kind.distortion == Model::kFisheye;  // also if all are zero
  for (size_t i = center + 2; i < p.size(); ++i) {
    camera.distortion.k[i - center - 2] = p[i];
    distorts = distorts || p[i] != 0;
  }
  if (distorts) camera.distortion.model = kind.distortion;
}

}  // namespace

const ColmapModelKind* FindColmapModelKind(int id) {
  for (const ColmapModelKind& kind : kModels)
    if (id == kind.id) return &kind;
  return nullptr;
}

ColmapCamera MakeColmapCamera(const std::string& file,
                              const std::string& field,
                              const std::string& model,
                              const std::array<int64_t, 2>& size,
                              const std::vector<double>& params) {
  const ColmapModelKind* kind = FindByName(model);
  if (kind == nullptr || kind->focals == 0)
    throw Error(file,
                field,
                "camera model " + model + " cannot be undistorted: " +
                    (kind != nullptr && kind->id == kEquirectangular
                         ? "cut the panoramas into perspective photographs first"
                         : "run COLMAP's image_undistorter"));
  if (int(params.size()) != kind->params)
    throw Error(file,
                field,
                Format("{} has {} parameters, expected {}", model, params.size(), kind->params));
  for (double p : params)
    if (!std::isfinite(p)) throw Error(file, field, model + " has a parameter that is not finite");
  constexpr int64_t kMaxSide = 1 << 20;
  if (size[0] < 1 || size[1] < 1 || size[0] > kMaxSide || size[1] > kMaxSide)
    throw Error(file, field, Format("image size {}x{} is impossible", size[0], size[1]));
  ColmapCamera camera;
  camera.lens.width = int(size[0]);
  camera.lens.height = int(size[1]);
  SetParams(*kind, params, camera);
  if (!(camera.lens.fx > 0) || !(camera.lens.fy > 0))
    throw Error(file, field, "focal length " + std::to_string(params[0]) + " is not positive");
  return camera;
}

ColmapModel ReadColmapModel(const std::string& folder) {
  ColmapModel model;
  if (std::filesystem::exists(folder + "/cameras.bin")) {
    model.images_file = folder + "/images.bin";
    colmap::ReadBinary(folder, model);
  } else if (std::filesystem::exists(folder + "/cameras.txt")) {
    model.images_file = folder + "/images.txt";
    colmap::ReadText(folder, model);
  } else {
    throw Error(folder, "contains no COLMAP model (neither cameras.bin nor cameras.txt)");
  }
  for (const ColmapImage& image : model.images)
    if (!model.cameras.contains(image.camera_id))
      throw Error(model.images_file,
                  image.name,
                  "refers to camera " + std::to_string(image.camera_id) + ", which does not exist");
  for (size_t i = 0; i < model.points.size(); ++i)
    if (!std::isfinite(float(model.points[i])))
      throw Error(folder, "points3D, record " + std::to_string(i / 3), "is not finite");
  return model;
}

}  // namespace cosplat

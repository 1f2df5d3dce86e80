// What `cosplat export` writes: a scene, an avatar, a stand-alone splat file, or an avatar trained
// with GaussianAvatars.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "apps/cosplat/run/head_model.h"
#include "splat/io/dataset.h"

namespace cosplat {

struct ExportSource {
  std::string model;        // run folder, or empty
  std::string splats;       // splat file that replaces the run's own, or empty
  std::string data, flame;  // override the paths in run.json unless empty
  bool views = false;       // of a scene's run, load its views
  bool measure = false;     // and require test views
};

struct ExportSubject {
  std::string path;  // of the splat file
  // With the axes of scenes, OpenCV's, as 3DGS's SH; of an avatar, at rest with its face to -z.
  Gaussians gaussians;
  SceneData data;                        // without views unless asked for
  std::array<float, 3> background = {};  // of the run
  bool is_avatar = false;
  std::optional<PosableAvatar> imported;  // avatars that were trained with GaussianAvatars
};

// Throws Error if something is missing, or if `measure` is set and there is no scene with test
// views.
ExportSubject LoadExportSubject(const ExportSource& source);

// [N] what an error in the colour of each Gaussian weighs, for codebooks: by the training views, or
// by size if there are none.
std::vector<float> SignificanceOf(const ExportSubject& subject);

// SeenBands of the Gaussians, truncated to kMaxSplatFileDegree, from the training views; empty if
// there are none.
std::vector<float> SeenBandsOf(const ExportSubject& subject);

// A scene, or an avatar that has no .glb yet. Throws Error for one that has.
void ExportGlb(const std::string& path, const ExportSubject& subject, bool truncate_degree);

// An imported avatar as a run's folder for `render`, `metrics` and `play`. Throws Error for
// anything else, and if the source has no data set.
void ExportRun(const std::string& folder,
               const ExportSource& source,
               const ExportSubject& subject,
               bool truncate_degree);

}  // namespace cosplat

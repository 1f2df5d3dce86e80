// One function per layout of scene data. Each fills layout, points and skipped, and puts views into
// `train` (and `test` where the data has its own split); LoadScene splits and checks.
#pragma once

#include <string>

#include "splat/io/dataset.h"

namespace cosplat {

// <path>/sparse/0 or <path>/sparse, with pictures in <path>/images or images_N.
bool IsColmapScene(const std::string& path);
void LoadColmapScene(const std::string& path, const SceneOptions& options, SceneData& scene);

// <path>/transforms_train.json and, where present, transforms_test.json.
bool IsBlenderScene(const std::string& path);
void LoadBlenderScene(const std::string& path, const SceneOptions& options, SceneData& scene);

// <path>/transforms.json of nerfstudio or instant-ngp.
bool IsNerfstudioScene(const std::string& path);
void LoadNerfstudioScene(const std::string& path, const SceneOptions& options, SceneData& scene);

}  // namespace cosplat

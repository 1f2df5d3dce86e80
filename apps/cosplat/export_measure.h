// What a file of splats makes of a run's test views, read back and rendered.
#pragma once

#include <functional>
#include <string>

#include "splat/base/json.h"
#include "splat/dataset.h"
#include "splat/gaussians.h"

namespace cosplat {

struct FileFigures {
  double mb = 0;  // of the file, 10^6 bytes
  double psnr = 0,
         ssim = 0;  // means over the test views, of pictures as bytes: as `metrics` has them
};

// Reads the file and renders the scene's test views, of which there must be one; `count_view` after
// each.
FileFigures MeasureFile(const std::string& path,
                        const SceneData& scene,
                        const std::array<float, 3>& background,
                        const std::function<void()>& count_view);

// "2.57 MB  PSNR 31.61 dB  SSIM 0.9333".
std::string ToString(const FileFigures& figures);

}  // namespace cosplat

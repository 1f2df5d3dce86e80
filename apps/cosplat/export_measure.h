// Image quality of a splat file: a scene's test views rendered from the file after reading it back.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "splat/gaussians.h"
#include "splat/io/dataset.h"

namespace cosplat {

struct FileFigures {
  double mb = 0;              // file size, 10^6 bytes
  double psnr = 0, ssim = 0;  // means over the views, on 8-bit images as in `metrics`
};

// `path`: the file whose size is measured; `gaussians`: what was read from it. `count_view` is
// called after each view. Views that show nothing are in no mean (HasContent); throws Error if none
// shows anything.
FileFigures Measure(const std::string& path,
                    const Gaussians& gaussians,
                    const SceneData& scene,
                    const std::array<float, 3>& background,
                    const std::function<void()>& count_view);

// "2.57 MB  PSNR 31.61 dB  SSIM 0.9333".
std::string ToString(const FileFigures& figures);

}  // namespace cosplat

// Image quality of a splat file: a run's test views rendered from the file after reading it back.
#pragma once

#include <functional>
#include <string>

#include "avatar/model/avatar_model.h"
#include "flame/track.h"
#include "splat/io/dataset.h"
#include "splat/render/rasterizer.h"

namespace cosplat {

struct TestViews {
  size_t count = 0;
  std::array<float, 3> background{};
  std::function<void(size_t view, RenderedImage& image)> render;  // composited over the background
  std::function<Image8(size_t view)> ground_truth;
};

// The returned views keep references to the arguments, which must outlive them.
TestViews ViewsOfScene(const Gaussians& gaussians,
                       const SceneData& scene,
                       const std::array<float, 3>& background);
// `model` must have its mesh.
TestViews ViewsOfAvatar(const AvatarModel& model,
                        const FlameModel& flame,
                        const TrackedVideo& video,
                        const std::array<float, 3>& background);

struct FileFigures {
  double mb = 0;              // file size, 10^6 bytes
  double psnr = 0, ssim = 0;  // means over the views, on 8-bit images as in `metrics`
};

// `path`: the file whose size is measured. `count_view` is called after each view.
FileFigures Measure(const std::string& path,
                    const TestViews& views,
                    const std::function<void()>& count_view);

// "2.57 MB  PSNR 31.61 dB  SSIM 0.9333".
std::string ToString(const FileFigures& figures);

}  // namespace cosplat

// What a file of splats makes of a run's test views, read back and rendered.
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
  std::function<void(size_t view, RenderedImage& image)> render;  // over the background
  std::function<Image8(size_t view)> photograph;
};

// Both keep references to what is to be rendered.
TestViews ViewsOfScene(const Gaussians& gaussians,
                       const SceneData& scene,
                       const std::array<float, 3>& background);
// The model with its mesh.
TestViews ViewsOfAvatar(const AvatarModel& model,
                        const FlameModel& flame,
                        const TrackedVideo& video,
                        const std::array<float, 3>& background);

struct FileFigures {
  double mb = 0;              // of the file, 10^6 bytes
  double psnr = 0, ssim = 0;  // means over the views, of images as bytes: as `metrics` has them
};

// `path`: the file whose size counts. `count_view` is called after each view.
FileFigures Measure(const std::string& path,
                    const TestViews& views,
                    const std::function<void()>& count_view);

// "2.57 MB  PSNR 31.61 dB  SSIM 0.9333".
std::string ToString(const FileFigures& figures);

}  // namespace cosplat

#include "apps/cosplat/export_measure.h"

#include <cstdio>
#include <filesystem>
#include <memory>

#include "avatar/play/player.h"
#include "splat/eval/metrics.h"
#include "splat/train/loss.h"

namespace cosplat {

TestViews ViewsOfScene(const Gaussians& gaussians,
                       const SceneData& scene,
                       const std::array<float, 3>& background) {
  const std::shared_ptr<Rasterizer> rasterizer = MakeCpuRasterizer();
  const std::shared_ptr<RenderTape> tape = rasterizer->MakeTape();
  TestViews views{scene.test.size(), background, {}, {}};
  views.render = [=, &gaussians, &scene](size_t i, RenderedImage& image) {
    const RenderSettings settings{background, gaussians.degree};
    const Camera& camera = scene.test[i].camera;
    rasterizer->Forward(ViewOf(gaussians), gaussians.basis, camera, settings, image, *tape);
  };
  views.ground_truth = [&scene](size_t i) { return LoadViewImage(scene.test[i]); };
  return views;
}

TestViews ViewsOfAvatar(const AvatarModel& model,
                        const FlameModel& flame,
                        const TrackedVideo& video,
                        const std::array<float, 3>& background) {
  const auto player = std::make_shared<Player>(model, flame);
  TestViews views{video.test.size(), background, {}, {}};
  views.render = [=, &video](size_t i, RenderedImage& image) {
    player->RenderOver(video.test[i].params, video.test[i].camera, background, image);
  };
  views.ground_truth = [&video](size_t i) { return LoadTrackedImage(video, video.test[i]); };
  return views;
}

FileFigures Measure(const std::string& path,
                    const TestViews& views,
                    const std::function<void()>& count_view) {
  FileFigures figures;
  figures.mb = double(std::filesystem::file_size(path)) / 1e6;
  RenderedImage image, truth;
  for (size_t i = 0; i < views.count; ++i) {
    views.render(i, image);
    truth.width = image.width;
    truth.height = image.height;
    CompositeTarget(views.ground_truth(i), views.background, truth.color);
    const ImageMetrics m = CompareImages(ToBytes(image.ToImage()), ToBytes(truth.ToImage()));
    figures.psnr += m.psnr / double(views.count);
    figures.ssim += m.ssim / double(views.count);
    count_view();
  }
  return figures;
}

std::string ToString(const FileFigures& f) {
  char text[96];
  std::snprintf(text, sizeof text, "%.2f MB  PSNR %.2f dB  SSIM %.4f", f.mb, f.psnr, f.ssim);
  return text;
}

}  // namespace cosplat

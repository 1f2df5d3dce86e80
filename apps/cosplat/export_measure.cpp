#include "apps/cosplat/export_measure.h"

#include <cstdio>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/eval/metrics.h"
#include "splat/render/rasterizer.h"
#include "splat/train/loss/loss.h"

namespace cosplat {

FileFigures Measure(const std::string& path,
                    const Gaussians& gaussians,
                    const SceneData& scene,
                    const std::array<float, 3>& background,
                    const std::function<void()>& count_view) {
  FileFigures figures;
  figures.mb = double(std::filesystem::file_size(path)) / 1e6;
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const RenderSettings settings{background, gaussians.degree};
  int measured = 0;
  RenderedImage image, truth;
  for (const SceneView& view : scene.test) {
    rasterizer->Forward(ViewOf(gaussians), gaussians.basis, view.camera, settings, image, *tape);
    truth.width = image.width;
    truth.height = image.height;
    CompositeTarget(LoadViewImage(view), background, truth.color);
    count_view();
    const Image8 held_out = ToBytes(truth.ToImage());
    if (!HasContent(held_out)) continue;
    const ImageMetrics m = CompareImages(ToBytes(image.ToImage()), held_out);
    figures.psnr += m.psnr;
    figures.ssim += m.ssim;
    ++measured;
  }
  if (measured == 0)
    throw Error("--measure", "there is nothing to compare: each test image is all of one colour");
  figures.psnr /= measured;
  figures.ssim /= measured;
  return figures;
}

std::string ToString(const FileFigures& f) {
  return Format("{:.2f} MB  PSNR {:.2f} dB  SSIM {:.4f}", f.mb, f.psnr, f.ssim);
}

}  // namespace cosplat

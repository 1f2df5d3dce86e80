#include "apps/cosplat/export_measure.h"

#include <cstdio>
#include <filesystem>

#include "splat/io/splat_file.h"
#include "splat/loss.h"
#include "splat/metrics.h"
#include "splat/rasterizer.h"

namespace cosplat {

FileFigures MeasureFile(const std::string& path,
                        const SceneData& scene,
                        const std::array<float, 3>& background,
                        const std::function<void()>& count_view) {
  FileFigures figures;
  figures.mb = double(std::filesystem::file_size(path)) / 1e6;
  const Gaussians g = ReadSplats(path);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image, truth;
  for (const SceneView& view : scene.test) {
    rasterizer->Forward(ViewOf(g), g.basis, view.camera, {background, g.degree}, image, *tape);
    truth.width = image.width;
    truth.height = image.height;
    CompositeTarget(LoadViewImage(view), background, truth.color);
    const ImageMetrics m = CompareImages(ToBytes(image.ToImage()), ToBytes(truth.ToImage()));
    figures.psnr += m.psnr / double(scene.test.size());
    figures.ssim += m.ssim / double(scene.test.size());
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

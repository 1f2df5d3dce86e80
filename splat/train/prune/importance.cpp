#include "splat/train/prune/importance.h"

#include <algorithm>
#include <cmath>

#include "splat/render/rasterizer.h"
#include "splat/train/loss/loss.h"
#include "splat/train/loss/photograph.h"

namespace cosplat {
namespace {

constexpr double kVolumeQuantile = 0.9;
constexpr float kVolumePower = 0.1f;
constexpr float kInvisibleLogit = -30;  // an opacity far below a grey level

// Sums contributions over images.
class ContributionSum {
 public:
  explicit ContributionSum(size_t count)
      : rasterizer_(MakeCpuRasterizer()), tape_(rasterizer_->MakeTape()), sum_(count) {}

  void Add(const WorldGaussians& world,
           Basis basis,
           const Camera& camera,
           const RenderSettings& settings) {
    rasterizer_->Forward(world, basis, camera, settings, image_, *tape_);
    rasterizer_->Contributions(image_, *tape_, view_);
    for (size_t i = 0; i < sum_.size(); ++i) sum_[i] += view_[i];
  }
  std::vector<Contribution> Take() { return std::move(sum_); }

 private:
  std::unique_ptr<Rasterizer> rasterizer_;
  std::unique_ptr<RenderTape> tape_;
  RenderedImage image_;
  Buffer<Contribution> view_;
  std::vector<Contribution> sum_;
};

std::vector<uint8_t> NotIgnored(const TrainFrame& frame) {
  std::vector<uint8_t> use(frame.target.pixels(), 1);
  for (size_t i = 0; i < frame.ignored.data.size(); ++i) use[i] = frame.ignored.data[i] == 0;
  return use;
}

// Over the pixels that `ignored` ([pixels], empty: none) does not mark, and the channels.
struct SquaredDifference {
  double sum = 0;
  size_t count = 0;
};

SquaredDifference Difference(const Buffer<float>& a,
                             const Buffer<float>& b,
                             const Image8& ignored) {
  SquaredDifference d;
  const size_t pixels = a.size() / 3;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!ignored.empty() && ignored.data[i % pixels] != 0) continue;
    d.sum += double(a[i] - b[i]) * (a[i] - b[i]);
    ++d.count;
  }
  return d;
}

}  // namespace

ImageError ErrorOfFrames(Subject& subject,
                         const Gaussians& gaussians,
                         const FrameChoice& choice,
                         bool fits_exposure,
                         Rasterizer& rasterizer,
                         RenderTape& tape) {
  RenderedImage image, on_host;
  Buffer<float> target;
  ImageError error;
  int measured = 0;
  for (size_t k = 0; k < choice.count(); ++k) {
    const TrainFrame& frame = subject.frame(choice[k]);
    rasterizer.Forward(subject.ToWorld(gaussians, choice[k]),
                       gaussians.basis,
                       frame.camera,
                       {choice.background, choice.degree},
                       image,
                       tape);
    image.Download(on_host, rasterizer.stream());
    rasterizer.stream().Wait();
    CompositeTarget(frame.target, choice.background, target);
    if (fits_exposure)
      ApplyExposure(FitExposure(on_host.color, target, NotIgnored(frame)), on_host.color.view());
    for (float& c : on_host.color) c = std::clamp(c, 0.0f, 1.0f);
    const SquaredDifference d = Difference(on_host.color, target, frame.ignored);
    if (d.count == 0) continue;  // nothing of this frame is to be compared
    error.mean_psnr += PsnrOf(d.sum / double(d.count));
    error.squared += d.sum;
    ++measured;
  }
  if (measured > 0) error.mean_psnr /= measured;
  return error;
}

Camera WithMargin(Camera camera, float share) {
  const int x = int(std::lround(share * float(camera.width)));
  const int y = int(std::lround(share * float(camera.height)));
  camera.width += 2 * x;
  camera.height += 2 * y;
  camera.cx += float(x);
  camera.cy += float(y);
  return camera;
}

void Hide(View<const uint8_t> removed, Gaussians& gaussians) {
  for (size_t i = 0; i < removed.size(); ++i)
    if (removed[i] != 0) gaussians.at(kOpacityLogit, i)[0] = kInvisibleLogit;
}

std::vector<float> Significance(const Gaussians& gaussians,
                                const std::vector<Contribution>& contributions) {
  const size_t n = gaussians.size();
  std::vector<float> volume_log(n);
  for (size_t i = 0; i < n; ++i) {
    const float* s = gaussians.at(kScaleLog, i);
    volume_log[i] = s[0] + s[1] + s[2];
  }
  std::vector<float> significance(n);
  if (n == 0) return significance;
  std::vector<float> sorted = volume_log;
  const size_t k = std::min(n - 1, size_t(kVolumeQuantile * double(n)));
  std::nth_element(sorted.begin(), sorted.begin() + k, sorted.end());
  for (size_t i = 0; i < n; ++i)
    significance[i] = contributions[i].hits * std::exp(kVolumePower * (volume_log[i] - sorted[k]));
  return significance;
}

std::vector<float> GlobalSignificance(const Gaussians& gaussians,
                                      const std::vector<Camera>& cameras) {
  ContributionSum sum(gaussians.size());
  for (const Camera& camera : cameras)
    sum.Add(ViewOf(gaussians), gaussians.basis, camera, {{0, 0, 0}, gaussians.degree});
  return Significance(gaussians, sum.Take());
}

}  // namespace cosplat

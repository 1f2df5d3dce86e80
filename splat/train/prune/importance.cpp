#include "splat/train/prune/importance.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "splat/render/rasterizer.h"
#include "splat/train/loss/loss.h"
#include "splat/train/loss/photograph.h"

namespace cosplat {
namespace {

constexpr double kVolumeQuantile = 0.9;
constexpr float kVolumePower = 0.1f;

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

std::optional<double> PsnrWhere(const std::vector<uint8_t>& use,
                                const Buffer<float>& a,
                                const Buffer<float>& b) {
  Buffer<float> used_a, used_b;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!use[i % use.size()]) continue;
    used_a.push_back(a[i]);
    used_b.push_back(b[i]);
  }
  if (used_a.empty()) return {};
  return Psnr(used_a, used_b);
}

}  // namespace

double MeanPsnrOfFrames(Subject& subject,
                        const Gaussians& gaussians,
                        const FrameChoice& choice,
                        bool fits_exposure,
                        Rasterizer& rasterizer,
                        RenderTape& tape) {
  RenderedImage image, on_host;
  Buffer<float> target;
  double sum = 0;
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
    const std::optional<double> psnr = frame.ignored.empty()
                                           ? Psnr(on_host.color, target)
                                           : PsnrWhere(NotIgnored(frame), on_host.color, target);
    if (!psnr) continue;  // nothing of this frame is to be compared
    sum += *psnr;
    ++measured;
  }
  return measured == 0 ? 0 : sum / measured;
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

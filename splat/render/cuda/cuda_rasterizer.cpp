#include "splat/render/cuda/cuda_rasterizer.h"

#include "splat/render/cuda/renderer.h"
#include "splat/render/cuda/world_arrays.h"

namespace cosplat::cuda {
namespace {

class CudaTape : public RenderTape {
 public:
  View<const float> radii() const override { return radii_on_host; }
  size_t visible_count() const override { return tape.lists.visible(); }
  size_t instance_count() const override { return tape.lists.instances(); }
  std::vector<MemoryPart> Memory() const override {
    std::vector<MemoryPart> parts = tape.Memory();
    parts.push_back({"radii on the host", HeldBy(radii_on_host)});
    return parts;
  }

  Tape tape;
  Buffer<float> radii_on_host;
};

class CudaRasterizer : public Rasterizer {
 public:
  explicit CudaRasterizer(SumOrder order) : renderer_(order) {}

  std::unique_ptr<RenderTape> MakeTape() const override { return std::make_unique<CudaTape>(); }

  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings,
               RenderedImage& image,
               RenderTape& base_tape) override {
    auto& tape = static_cast<CudaTape&>(base_tape);
    const cudaStream_t stream = renderer_.stream().get();
    world_ = arrays_.Upload(gaussians, stream);
    renderer_.Forward(world_, basis, camera, settings, true, image_, tape.tape);
    image.width = image_.width;
    image.height = image_.height;
    image.color.resize(image_.color.size());
    image.transmittance.resize(image_.transmittance.size());
    tape.radii_on_host.resize(gaussians.count);
    image_.color.Download(image.color.data(), stream);
    image_.transmittance.Download(image.transmittance.data(), stream);
    tape.tape.radii.Download(tape.radii_on_host.data(), stream);
    renderer_.stream().Wait();
    AddTime(Phase::kProject, Renderer::kStart, Renderer::kProjected);
    AddTime(Phase::kSort, Renderer::kProjected, Renderer::kSorted);
    AddTime(Phase::kBlend, Renderer::kSorted, Renderer::kBlended);
  }

  void Backward(const WorldGaussians& gaussians,
                const RenderedImage& image,
                const Buffer<float>& d_color,
                RenderTape& base_tape,
                const WorldGradients& gradients) override {
    auto& tape = static_cast<CudaTape&>(base_tape);
    const cudaStream_t stream = renderer_.stream().get();
    UploadImage(image, stream);
    d_color_.Upload(d_color.data(), d_color.size(), stream);
    world_ = arrays_.Upload(gaussians, stream);
    const WorldGradients d =
        gradients_.Prepare(gradients, gaussians.count, gaussians.rest_width, stream);
    renderer_.Backward(world_, image_, d_color_.data(), tape.tape, d);
    gradients_.Download(gradients, stream);
    renderer_.stream().Wait();
    AddTime(Phase::kBackward, Renderer::kBackStart, Renderer::kBack);
  }

  void Contributions(const RenderedImage& image,
                     RenderTape& base_tape,
                     Buffer<Contribution>& contributions) override {
    auto& tape = static_cast<CudaTape&>(base_tape);
    UploadImage(image, renderer_.stream().get());
    renderer_.Contributions(image_, tape.tape, contributions_);
    contributions.resize(contributions_.size());
    contributions_.Download(contributions.data(), renderer_.stream().get());
    renderer_.stream().Wait();
  }

 private:
  void UploadImage(const RenderedImage& image, cudaStream_t stream) {
    image_.width = image.width;
    image_.height = image.height;
    image_.color.Upload(image.color.data(), image.color.size(), stream);
  }

  void AddTime(Phase phase, Renderer::Mark from, Renderer::Mark to) {
    times.seconds[size_t(phase)] += 1e-3 * renderer_.MillisecondsBetween(from, to);
  }

  Renderer renderer_;
  WorldArrays arrays_;
  WorldGradientArrays gradients_;
  WorldGaussians world_;  // on the device
  DeviceImage image_;
  DeviceBuffer<float> d_color_;
  DeviceBuffer<Contribution> contributions_;
};

}  // namespace

std::unique_ptr<Rasterizer> MakeCudaRasterizer(SumOrder order) {
  return std::make_unique<CudaRasterizer>(order);
}

}  // namespace cosplat::cuda

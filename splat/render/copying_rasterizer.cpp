#include <utility>

#include "splat/render/rasterizer.h"
#include "splat/render/world_arrays.h"

namespace cosplat {
namespace {

struct CopyingTape : RenderTape {
  explicit CopyingTape(std::unique_ptr<RenderTape> on_device) : on_device(std::move(on_device)) {}
  const InstanceCounts* counts() const override { return &drawn; }
  size_t capacity() const override { return on_device->capacity(); }
  std::vector<MemoryPart> Memory() const override {
    std::vector<MemoryPart> parts = on_device->Memory();
    parts.push_back({"radii on the host", AllocatedBytes(radius)});
    return parts;
  }

  std::unique_ptr<RenderTape> on_device;
  InstanceCounts drawn;
};

class CopyingRasterizer : public Rasterizer {
 public:
  explicit CopyingRasterizer(std::unique_ptr<Rasterizer> on_device)
      : on_device_(std::move(on_device)), stream_(on_device_->stream()) {}

  Stream& stream() override { return HostStream(); }
  std::unique_ptr<RenderTape> MakeTape(bool keep) const override {
    return std::make_unique<CopyingTape>(on_device_->MakeTape(keep));
  }

  void Forward(const WorldGaussians& gaussians,
               Basis basis,
               const Camera& camera,
               const RenderSettings& settings,
               RenderedImage& image,
               RenderTape& base_tape) override {
    auto& tape = static_cast<CopyingTape&>(base_tape);
    world_ = arrays_.Upload(gaussians, stream_);
    on_device_->Forward(world_, basis, camera, settings, image_, *tape.on_device);
    image_.Download(image, stream_);
    tape.radius.resize(gaussians.count);
    stream_.Download(
        tape.radius.data(), tape.on_device->radii().data, gaussians.count * sizeof(float));
    stream_.Download(&tape.drawn, tape.on_device->counts(), sizeof(InstanceCounts));
    stream_.Wait();
    on_device_->AddForwardTimes();
    times += std::exchange(on_device_->times, {});
  }

  void Backward(const WorldGaussians& gaussians,
                const RenderedImage& image,
                const Buffer<float>& d_color,
                RenderTape& base_tape,
                const WorldGradients& gradients) override {
    auto& tape = static_cast<CopyingTape&>(base_tape);
    image_.Upload(image, stream_);
    d_color_.Upload(d_color, stream_);
    world_ = arrays_.Upload(gaussians, stream_);
    const WorldGradients d =
        gradients_.Prepare(gradients, gaussians.count, gaussians.rest_width, stream_);
    on_device_->Backward(world_, image_, d_color_, *tape.on_device, d);
    gradients_.Download(gradients, stream_);
    stream_.Wait();
    on_device_->AddBackwardTimes();
    times += std::exchange(on_device_->times, {});
  }

  void Contributions(const RenderedImage& image,
                     RenderTape& base_tape,
                     Buffer<Contribution>& contributions) override {
    auto& tape = static_cast<CopyingTape&>(base_tape);
    image_.Upload(image, stream_);
    on_device_->Contributions(image_, *tape.on_device, contributions_);
    contributions_.Download(contributions, stream_);
    stream_.Wait();
  }

 private:
  std::unique_ptr<Rasterizer> on_device_;
  Stream& stream_;
  // In the device's memory:
  WorldArrays arrays_;
  WorldGradientArrays gradients_;
  WorldGaussians world_;
  RenderedImage image_;
  Buffer<float> d_color_;
  Buffer<Contribution> contributions_;
};

}  // namespace

std::unique_ptr<Rasterizer> MakeCopyingRasterizer(std::unique_ptr<Rasterizer> on_device) {
  return std::make_unique<CopyingRasterizer>(std::move(on_device));
}

}  // namespace cosplat

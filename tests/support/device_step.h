// A training step of one view on the device, with nothing coming back but, where it is asked for,
// the number of instances.
#pragma once

#include <memory>

#include "splat/render/cuda/rasterizer.h"
#include "splat/train/cuda/kernels.h"
#include "splat/train/loss/loss.h"
#include "splat/train/optimize/optimizer.h"
#include "splat/train/step/instance_forecast.h"

namespace cosplat::test {

class DeviceStep {
 public:
  DeviceStep(const Gaussians& start,
             const Camera& camera,
             const Image8& photograph,
             const RenderSettings& settings,
             const AdamSettings& rates,
             cuda::SumOrder order)
      : rasterizer(order),
        tape(true, order),
        camera_(camera),
        settings_(settings),
        rates_(rates),
        target_{photograph.width, photograph.height, photograph.channels},
        readback_(stream()) {
    cuda::ProvideTrainKernels();
    const AdamState first(start);
    gaussians.Upload(start, stream());
    gradients.RefillLike(gaussians, stream());
    adam.Upload(first, stream());
    target_bytes_.Upload(photograph.data.data(), photograph.data.size(), stream());
    target_.bytes = target_bytes_.data();
    overflowed_.Refill(1, stream());
    overflowed_.FillWithZeros(stream());
    stream().Wait();  // for the host's memory
  }

  void Draw() {
    if (forecast_.Knows()) tape.lists.Expect(forecast_.Of(0, gaussians.size()), overflowed_.data());
    rasterizer.Forward(ViewOf(gaussians), gaussians.basis, camera_, settings_, image, tape);
  }
  void Compare() {
    loss_->Evaluate({}, image.color, target_, settings_.background, d_color_, stream());
  }
  void Backward() {
    WorldGradients out = GradientViewOf(gradients, screen_, stream());
    out.drawn_groups_only = true;  // Adam reads no others
    rasterizer.Backward(ViewOf(gaussians), image, d_color_, tape, out);
  }
  void Update() {
    AdamStepAll(rates_, gradients, {}, tape.radii(), gaussians, adam, stream(), overflowed_.data());
  }
  void Run() {
    Draw();
    Compare();
    Backward();
    Update();
  }
  // Waits; the next Draw then does not. False where there was no capacity for the step, which
  // changed nothing.
  bool Settle() {
    counts = readback_.Get(tape.counts(), stream());
    forecast_.Saw(0, gaussians.size(), counts.instances);
    if (counts.instances <= tape.capacity()) return true;
    overflowed_.FillWithZeros(stream());
    --adam.step;
    return false;
  }
  // Of the last step; waits.
  double Loss() { return Readback<double>(stream()).Get(loss_->value(), stream()); }
  Stream& stream() { return rasterizer.stream(); }

  cuda::CudaRasterizer rasterizer;
  Gaussians gaussians, gradients;
  cuda::CudaTape tape;
  RenderedImage image;
  AdamState adam;
  InstanceCounts counts;  // as it settled last

 private:
  Camera camera_;
  RenderSettings settings_;
  AdamSettings rates_;
  std::unique_ptr<StepLoss> loss_ = cuda::MakeCudaLoss();
  Buffer<uint8_t> target_bytes_;
  TargetView target_;
  Buffer<float> d_color_, screen_;
  Buffer<uint32_t> overflowed_;
  InstanceForecast forecast_;
  Readback<InstanceCounts> readback_;
};

}  // namespace cosplat::test

// A training step of one view on the device, with nothing coming back but, where it is asked for,
// the number of instances.
#pragma once

#include "splat/render/cuda/instance_forecast.h"
#include "splat/render/cuda/renderer.h"
#include "splat/train/cuda/adam.h"
#include "splat/train/cuda/loss.h"

namespace cosplat::test {

class DeviceStep {
 public:
  DeviceStep(const Gaussians& start,
             const Camera& camera,
             const Image8& photograph,
             const RenderSettings& settings,
             const AdamSettings& rates,
             cuda::SumOrder order)
      : renderer(order), basis_(start.basis), camera_(camera), settings_(settings), rates_(rates) {
    gaussians.Upload(start, stream());
    gradients.ResizeLike(gaussians);
    target_.Upload(photograph, stream());
    adam.Start(gaussians, stream());
    overflowed_.Refill(1);
    overflowed_.FillWithZeros(stream());
    adam.overflowed = overflowed_.data();
  }

  void Draw() {
    if (forecast_.Knows()) tape.lists.Expect(forecast_.Of(0, gaussians.size()), overflowed_.data());
    renderer.Forward(gaussians.View(), basis_, camera_, settings_, true, image, tape);
  }
  void Compare() {
    loss.Evaluate({}, image.color.data(), target_, settings_.background, d_color_, stream());
  }
  void Backward() {
    WorldGradients out = gradients.GradientView(screen_);
    out.drawn_groups_only = true;  // Adam reads no others
    renderer.Backward(gaussians.View(), image, d_color_.data(), tape, out);
  }
  void Update() {
    adam.Step(rates_, gradients, std::as_const(tape.radii).view(), nullptr, gaussians, stream());
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
    counts = readback_.Get(tape.lists.counts(), stream());
    forecast_.Saw(0, gaussians.size(), counts.instances);
    if (counts.instances <= tape.lists.capacity()) return true;
    overflowed_.FillWithZeros(stream());
    --adam.step;
    return false;
  }
  cudaStream_t stream() const { return renderer.stream().get(); }

  cuda::Renderer renderer;
  cuda::DeviceGaussians gaussians, gradients;
  cuda::Tape tape;
  cuda::DeviceImage image;
  cuda::PhotometricLoss loss;
  cuda::Adam adam;
  cuda::TileLists::Counts counts{};  // as it settled last

 private:
  Basis basis_;
  Camera camera_;
  RenderSettings settings_;
  AdamSettings rates_;
  cuda::DeviceTarget target_;
  cuda::DeviceBuffer<float> d_color_, screen_;
  cuda::DeviceBuffer<uint32_t> overflowed_;
  cuda::InstanceForecast forecast_;
  cuda::Readback<cuda::TileLists::Counts> readback_;
};

}  // namespace cosplat::test

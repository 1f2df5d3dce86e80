// The loss of a drawn view, and its gradient with respect to the image.
//
//   image -> stages (layers of other blocks, the photograph's exposure) -> photometric loss, crop
//   loss -> the stages' backward passes
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "splat/device/buffer.h"
#include "splat/render/rasterizer.h"
#include "splat/train/blocks/layers.h"
#include "splat/train/loss/image_stage.h"
#include "splat/train/loss/photograph.h"
#include "splat/train/step/steps_in_flight.h"
#include "splat/train/step/train_settings.h"
#include "splat/train/subject/target_store.h"

namespace cosplat {

// Layers as a stage; also what is behind the block.
class LayerStage : public ImageStage {
 public:
  bool Changes(const StageFrame& frame) const override { return !frame.layers->empty(); }
  const Buffer<float>& Forward(View<const float> image,
                               const StageFrame& frame,
                               Stream& stream) override {
    return model_.Forward(*frame.layers, image, stream);
  }
  void Backward(View<const float>,
                const StageFrame& frame,
                Buffer<float>& d,
                Stream& stream) override {
    model_.Backward(*frame.layers, d, stream);
  }
  size_t allocated_bytes() const override { return model_.allocated_bytes(); }
  LayerModel& model() { return model_; }

 private:
  LayerModel model_;
};

class PhotographStage : public ImageStage {
 public:
  bool Changes(const StageFrame& frame) const override {
    return frame.exposure || frame.target.ignored;
  }
  const Buffer<float>& Forward(View<const float> image,
                               const StageFrame& frame,
                               Stream& stream) override {
    return model_.Forward(image, frame.exposure, frame.target, frame.background, stream);
  }
  void Backward(View<const float> image,
                const StageFrame& frame,
                Buffer<float>& d,
                Stream& stream) override {
    model_.Backward(image, frame.exposure, frame.target, d, stream);
  }
  size_t allocated_bytes() const override { return model_.allocated_bytes(); }
  PhotographModel& model() { return model_; }
  const PhotographModel& model() const { return model_; }

 private:
  PhotographModel model_;
};

class FrameLoss {
 public:
  // max_bytes: of target images on a device. What is borrowed must outlive this.
  FrameLoss(const TrainSettings& settings,
            const Subject& subject,
            StepLoss& loss,
            Stream& stream,
            size_t max_bytes);

  // Where the crop loss is measured, if there is one; draws from rng then.
  bool has_crop() const { return settings_.crop_loss.weight != 0; }
  Crop ChooseCrop(const StepPlan& plan, Rng& rng);
  // Settings to draw the view with: over black where layers are behind it.
  RenderSettings RenderOf(const StepPlan& plan);
  // Puts what is behind the block into the drawn image.
  void AddBehind(const StepPlan& plan, RenderedImage& image);
  // Asks for the loss. exposure: [12] of the frame, or null. Waits for a device if there is a crop
  // loss.
  void Evaluate(const float* exposure, const RenderedImage& image, SubmittedStep& step);
  // With respect to the drawn image, after Evaluate.
  const Buffer<float>& d_color() const { return d_color_; }
  // [12] with respect to the exposure.
  const Buffer<float>& d_exposure() const { return photograph_.model().gradient(); }
  PhotographModel& photograph() { return photograph_.model(); }
  std::vector<MemoryPart> Memory() const;

 private:
  // Adds the crop loss and its gradient to those of the photometric loss. compared: the last
  // stage's image.
  void AddCropLoss(SubmittedStep& step, const Buffer<float>& compared, const RenderedImage& image);

  const TrainSettings& settings_;
  StepLoss& loss_;
  Stream& stream_;
  TargetStore targets_;
  LayerStage layers_;
  PhotographStage photograph_;
  Buffer<float> d_color_;
  Buffer<float> crop_, rendered_crop_, target_crop_;  // the last two in host memory
  std::vector<float> d_crop_;
};

}  // namespace cosplat

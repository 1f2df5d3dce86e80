#include "splat/train/step/frame_loss.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "splat/device/for_each.h"
#include "splat/train/loss/kernels/crop.h"

namespace cosplat {

FrameLoss::FrameLoss(const TrainSettings& settings,
                     const Subject& subject,
                     StepLoss& loss,
                     Stream& stream,
                     size_t max_bytes)
    : settings_(settings), loss_(loss), stream_(stream), targets_(subject, max_bytes) {}

Crop FrameLoss::ChooseCrop(const StepPlan& plan, Rng& rng) {
  return DrawCrop(targets_.ImageOf(plan.frame, plan.downscale), settings_.crop_loss.side, rng);
}

RenderSettings FrameLoss::RenderOf(const StepPlan& plan) {
  RenderSettings render = plan.render;
  if (!targets_.LayersOf(plan.frame, plan.downscale).empty()) render.background = {0, 0, 0};
  return render;
}

void FrameLoss::AddBehind(const StepPlan& plan, RenderedImage& image) {
  const FrameLayers& layers = targets_.LayersOf(plan.frame, plan.downscale);
  if (!layers.empty()) layers_.model().AddBehind(layers, plan.render.background, image, stream_);
}

void FrameLoss::Evaluate(const float* exposure, const RenderedImage& image, SubmittedStep& step) {
  const StepPlan& plan = step.plan;
  const StageFrame frame{targets_.Of(plan.frame, plan.downscale, stream_),
                         plan.render.background,
                         exposure,
                         &targets_.LayersOf(plan.frame, plan.downscale)};
  // The stages that change the image, with what each was given; a step allocates nothing.
  std::array<std::pair<ImageStage*, const Buffer<float>*>, 2> done;
  size_t count = 0;
  const Buffer<float>* compared = &image.color;
  for (ImageStage* stage :
       {static_cast<ImageStage*>(&layers_), static_cast<ImageStage*>(&photograph_)})
    if (stage->Changes(frame)) {
      done[count++] = {stage, compared};
      compared = &stage->Forward(*compared, frame, stream_);
    }
  loss_.Evaluate(settings_.LossAt(plan.iteration),
                 *compared,
                 frame.target,
                 plan.render.background,
                 d_color_,
                 stream_);
  step.photometric.Ask(loss_.value(), stream_);
  if (has_crop()) AddCropLoss(step, *compared, image);
  while (count-- > 0) done[count].first->Backward(*done[count].second, frame, d_color_, stream_);
}

void FrameLoss::AddCropLoss(SubmittedStep& step,
                            const Buffer<float>& compared,
                            const RenderedImage& image) {
  const CropLossSettings& settings = settings_.crop_loss;
  const StepPlan& plan = step.plan;
  const CropPlaces places{plan.crop, image.width, image.height};
  const size_t numbers = 3 * size_t(plan.crop.width) * size_t(plan.crop.height);
  crop_.Refill(numbers, stream_);
  ForEach(numbers, stream_, CopyCrop{places, compared.view(), crop_.view()});
  crop_.Download(rendered_crop_, stream_);
  stream_.Wait();
  // On a device this shows before its loss does.
  const bool finite = std::all_of(
      rendered_crop_.begin(), rendered_crop_.end(), [](float v) { return std::isfinite(v); });
  if (settings_.batch == 1) CheckLoss(finite ? 0 : NAN, plan.iteration);
  if (!finite) {  // of several views: all ranks throw together
    step.of_crop = NAN;
    return;
  }
  CompositeTarget(Cropped(targets_.ImageOf(plan.frame, plan.downscale), plan.crop),
                  plan.render.background,
                  target_crop_);
  step.of_crop = settings.weight *
                 settings.distance->Evaluate(
                     rendered_crop_, target_crop_, plan.crop.width, plan.crop.height, d_crop_);
  stream_.Send(crop_.data(), d_crop_.data(), numbers * sizeof(float));
  ForEach(numbers,
          stream_,
          AddCrop{places, settings.weight, std::as_const(crop_).view(), d_color_.view()});
}

std::vector<MemoryPart> FrameLoss::Memory() const {
  return {
      {"image and its gradient",
       AllocatedBytes(d_color_, crop_) + photograph_.allocated_bytes() + layers_.allocated_bytes(),
       MemoryOf::kPixels},
      {"target images", targets_.allocated_bytes(), MemoryOf::kPixels},
      {"downscaled target images", targets_.ReducedBytes(), MemoryOf::kPixels}};
}

}  // namespace cosplat

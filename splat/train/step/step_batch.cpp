// StepEngine's steps of several views.
#include <algorithm>
#include <cstring>
#include <utility>

#include "splat/train/step/step_engine.h"

namespace cosplat {

double StepEngine::StepBatch(std::vector<StepPlan> views) {
  const StepPlan& plan = views.front();  // what does not differ between them
  if (settings_.crop_loss.weight != 0)
    for (StepPlan& view : views)
      view.crop = DrawCrop(
          targets_.ImageOf(view.frame, view.downscale), settings_.crop_loss.side, state_.rng);
  Submitted& step = steps_[0];
  all_.Release();
  fetched_ = false;
  sum_.Begin(now_->gaussians, views.size());
  world_ = subject_.Place(now_->gaussians, plan.frame);
  std::vector<ViewResult> own;
  for (size_t first = 0; first < views.size(); first += device_.ranks->size())
    RunRound(views, first, step, own);
  const std::vector<ViewResult> results = ExchangeResults(own, views.size());
  double loss = 0;
  for (const ViewResult& result : results) loss += result.loss;
  loss /= double(results.size());
  CheckLoss(loss, plan.iteration);
  const bool regularizes = settings_.scale_regularizer.weight != 0;
  const bool moves_all = settings_.adam_on == AdamOn::kAll;
  if (regularizes || moves_all) sum_.ZeroUnseen();
  const View<const float> moves = RegularizeScale(step, sum_.moves(), sum_.gradients());
  Update(plan, moves_all ? View<const float>() : moves, sum_.gradients());
  if (settings_.exposure) UpdateExposures(views, results);
  exchanged_.groups_updated += sum_.CountSeen();
  exchanged_.views += views.size();
  ++exchanged_.steps;
  stream_.Wait();
  return loss + (regularizes ? step.of_needles.Last() : 0);
}

void StepEngine::RunRound(const std::vector<StepPlan>& views,
                          size_t first,
                          Submitted& step,
                          std::vector<ViewResult>& own) {
  const size_t ranks = device_.ranks->size(), mine = first + device_.ranks->rank();
  const Basis basis = now_->gaussians.basis;
  std::vector<RoundView> round;
  for (size_t v = first; v < std::min(first + ranks, views.size()); ++v)
    round.push_back(
        {Reduced(subject_.camera(views[v].frame), views[v].downscale), views[v].render.degree});
  exchange_.Project(world_, basis, round, *tape_);
  if (mine < views.size()) own.push_back(DrawOwn(step, views[mine]));
  exchange_.Return(*tape_, [&](const ViewExchange::Part& part) {
    const Camera& camera = part.view.camera;
    gradients_.RefillLike(now_->gaussians, stream_, part.gaussians.count);
    device_.rasterizer->ProjectBackward(part.gaussians,
                                        basis,
                                        camera,
                                        part.view.degree,
                                        part.splats,
                                        part.radii.data,
                                        part.d_splats,
                                        subject_.WorldGradientsFor(gradients_, screen_, stream_));
    ScopedPhase phase(times_, Phase::kDensity);
    sum_.Add({gradients_, screen_.view(), part.radii, camera.width, camera.height},
             part.first,
             now_->gaussians,
             views[first].gathers_statistics ? &now_->statistics : nullptr);
  });
}

StepEngine::ViewResult StepEngine::DrawOwn(Submitted& step, const StepPlan& plan) {
  step.plan = plan;
  step.masked = false;
  const RenderSettings render = RenderOf(plan);
  const Camera camera = targets_.CameraOf(plan.frame, plan.downscale);
  CheckArguments(world_, camera, render);
  device_.rasterizer->Draw(camera, render, image_, *tape_);
  FinishDrawing(step);
  Evaluate(step);
  device_.rasterizer->DrawBackward(image_, d_color_, *tape_);
  ViewResult result;
  if (settings_.exposure) photograph_.gradient().Download(result.exposure.data(), stream_);
  stream_.Wait();
  result.loss = step.photometric.Last() + step.of_crop;
  return result;
}

std::vector<StepEngine::ViewResult> StepEngine::ExchangeResults(const std::vector<ViewResult>& own,
                                                                size_t views) {
  static_assert(sizeof(ViewResult) % sizeof(uint32_t) == 0);
  const Ranks& ranks = *device_.ranks;
  Message mine(own.size() * sizeof(ViewResult) / sizeof(uint32_t));
  if (!own.empty()) std::memcpy(mine.data(), own.data(), mine.size() * sizeof(uint32_t));
  std::vector<Message> of_ranks = ExchangeWithAll(mine, *device_.ranks);
  of_ranks[ranks.rank()] = std::move(mine);
  std::vector<ViewResult> results(views);
  for (size_t v = 0; v < views; ++v)
    std::memcpy(
        &results[v],
        reinterpret_cast<const ViewResult*>(of_ranks[v % ranks.size()].data()) + v / ranks.size(),
        sizeof(ViewResult));
  return results;
}

void StepEngine::UpdateExposures(const std::vector<StepPlan>& views,
                                 const std::vector<ViewResult>& results) {
  for (size_t v = 0; v < views.size(); ++v) {
    const Exposure& gradient = results[v].exposure;
    exposure_gradient_.Upload(gradient.data(), gradient.size(), stream_);
    photograph_.Update(views[v].frame,
                       views[v].exposure_rate,
                       exposure_gradient_,
                       overflowed_.data(),
                       now_->exposures,
                       stream_);
  }
}

}  // namespace cosplat

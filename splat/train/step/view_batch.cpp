#include "splat/train/step/view_batch.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "splat/train/subject/reduced_frames.h"

namespace cosplat {

ViewBatch::ViewBatch(Subject& subject, Ranks& ranks, StagedRasterizer& rasterizer)
    : subject_(subject),
      ranks_(ranks),
      rasterizer_(rasterizer),
      stream_(rasterizer.stream()),
      exchange_(ranks, rasterizer),
      sum_(stream_) {}

std::vector<ViewResult> ViewBatch::Run(std::span<const StepPlan> views,
                                       TrainingState& state,
                                       Drawing& drawing,
                                       PhaseTimes& times,
                                       const DrawView& draw) {
  sum_.Begin(state.gaussians, views.size());
  drawing.world = subject_.ToWorld(state.gaussians, views.front().frame);
  std::vector<ViewResult> own;
  const size_t ranks = ranks_.size();
  for (size_t first = 0; first < views.size(); first += ranks) {
    std::vector<RoundView> round;
    for (size_t v = first; v < std::min(first + ranks, views.size()); ++v)
      round.push_back(
          {Reduced(subject_.camera(views[v].frame), views[v].downscale), views[v].render.degree});
    exchange_.Project(drawing.world, state.gaussians.basis, round, *drawing.tape);
    const size_t mine = first + ranks_.rank();
    if (mine < views.size()) own.push_back(draw(views[mine]));
    exchange_.Return(*drawing.tape, [&](const ViewExchange::Part& part) {
      AddPart(part, views[first].gathers_statistics, state, drawing, times);
    });
  }
  counted_.views += views.size();
  ++counted_.steps;
  counted_.groups_updated += sum_.CountSeen();
  return ExchangeResults(own, views.size());
}

void ViewBatch::AddPart(const ViewExchange::Part& part,
                        bool gathers_statistics,
                        TrainingState& state,
                        Drawing& drawing,
                        PhaseTimes& times) {
  const Camera& camera = part.view.camera;
  drawing.gradients.RefillLike(state.gaussians, stream_, part.gaussians.count);
  rasterizer_.ProjectBackward(
      part.gaussians,
      state.gaussians.basis,
      camera,
      part.view.degree,
      part.splats,
      part.radii.data,
      part.d_splats,
      subject_.WorldGradientsFor(drawing.gradients, drawing.screen, stream_));
  ScopedPhase phase(times, Phase::kDensity);
  sum_.Add({drawing.gradients, drawing.screen.view(), part.radii, camera.width, camera.height},
           part.first,
           state.gaussians,
           gathers_statistics ? &state.statistics : nullptr);
}

std::vector<ViewResult> ViewBatch::ExchangeResults(const std::vector<ViewResult>& own,
                                                   size_t views) {
  static_assert(sizeof(ViewResult) % sizeof(uint32_t) == 0);
  Message mine(own.size() * sizeof(ViewResult) / sizeof(uint32_t));
  if (!own.empty()) std::memcpy(mine.data(), own.data(), mine.size() * sizeof(uint32_t));
  std::vector<Message> of_ranks = ExchangeWithAll(mine, ranks_);
  of_ranks[ranks_.rank()] = std::move(mine);
  std::vector<ViewResult> results(views);
  for (size_t v = 0; v < views; ++v)
    std::memcpy(
        &results[v],
        reinterpret_cast<const ViewResult*>(of_ranks[v % ranks_.size()].data()) + v / ranks_.size(),
        sizeof(ViewResult));
  return results;
}

const Buffer<float>& ViewBatch::Uploaded(const Exposure& gradient) {
  exposure_gradient_.Upload(gradient, stream_);
  return exposure_gradient_;
}

ExchangeStatistics ViewBatch::Exchanged(const Shards& shards, uint64_t assembled) const {
  ExchangeStatistics all = counted_;
  all.assembled = assembled;
  all.ranks = ranks_.size();
  // Before the sums, which send something themselves.
  const uint64_t bytes = ranks_.bytes_sent(), microseconds = uint64_t(1e6 * ranks_.seconds());
  all.bytes_sent = Sum(bytes, ranks_);
  all.seconds = 1e-6 * double(Sum(microseconds, ranks_)) / double(ranks_.size());
  all.groups_drawn = Sum(exchange_.groups_drawn(), ranks_);
  all.groups_updated = Sum(counted_.groups_updated, ranks_);
  all.handed_over = Sum(shards.numbers_sent(), ranks_);
  return all;
}

void ViewBatch::Release() {
  sum_.Release();
  exchange_.Release();
}

std::vector<MemoryPart> ViewBatch::Memory() const {
  return {{"gradients summed over views", sum_.allocated_bytes()},
          {"views exchanged between ranks", exchange_.allocated_bytes()}};
}

}  // namespace cosplat

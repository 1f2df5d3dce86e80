#include <ceres/ceres.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "flame/fit/face_texture.h"
#include "flame/fit/fit_landmarks.h"
#include "flame/fit/frame_priors.h"
#include "flame/fit/points_on_flame.h"
#include "flame/pose.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using internal::FaceTexture;
using internal::FrameView;

// Standard deviations of a frame's numbers about those of the given track: metres, radians, and
// FLAME's coefficients.
constexpr double kGivenTranslation = 0.01, kGivenHead = 0.05, kGivenJawAndEyes = 0.1,
                 kGivenExpression = 0.5;
// Height of the part of a head that is compared.
constexpr double kHeadReach = 0.22;  // metres

class TrackRefiner {
 public:
  TrackRefiner(const FlameModel& model,
               const TrackedVideo& video,
               std::vector<TrackedFrame*> track);
  std::vector<double> Run(const std::function<Image8(const TrackedFrame&)>& image);

  std::function<void()> tick;

 private:
  FrameView ViewOf(const TrackedFrame& frame) const;
  std::vector<double> NumbersOf(const FlameParams& params) const;
  void FitFrames();
  void FitFrame(size_t f, const std::vector<double>& near);
  void Return();

  const FlameModel& model_;
  const std::vector<TrackedFrame*> track_;
  std::vector<double> shape_;
  double log_focal_;
  std::vector<std::vector<double>> given_, frames_;
  std::vector<double> given_sigma_, step_sigma_;
  std::optional<FaceTexture> texture_;
};

TrackRefiner::TrackRefiner(const FlameModel& model,
                           const TrackedVideo& video,
                           std::vector<TrackedFrame*> track)
    : model_(model), track_(std::move(track)), log_focal_(std::log(track_[0]->camera.fx)) {
  const size_t shapes = std::min(video.shape.size(), size_t(model.shape_count));
  shape_.reserve(shapes + 1);  // Ceres takes no null pointer, not even for no numbers
  shape_.assign(video.shape.begin(), video.shape.begin() + long(shapes));
  for (const TrackedFrame* frame : track_) given_.push_back(NumbersOf(frame->params));
  frames_ = given_;
  given_sigma_.assign(frames_[0].size(), kGivenExpression);
  std::fill_n(given_sigma_.begin() + kFitTranslation, 3, kGivenTranslation);
  std::fill_n(given_sigma_.begin() + kFitPose, 6, kGivenHead);
  std::fill_n(given_sigma_.begin() + kFitPose + 6, 9, kGivenJawAndEyes);
  step_sigma_ = internal::StepSigma(int(frames_[0].size()), model.has_eyelids);
}

std::vector<double> TrackRefiner::NumbersOf(const FlameParams& params) const {
  std::vector<double> numbers(params.translation.begin(), params.translation.end());
  for (const auto& joint : params.pose) numbers.insert(numbers.end(), joint.begin(), joint.end());
  numbers.insert(numbers.end(), params.expression.begin(), params.expression.end());
  numbers.resize(size_t(kFitExpression + model_.expression_count));
  return numbers;
}

FrameView TrackRefiner::ViewOf(const TrackedFrame& frame) const {
  const Camera& camera = frame.camera;
  FrameView view;
  view.lens = {camera.cx, camera.cy};
  for (size_t r = 0; r < 3; ++r) {
    const double sign = r == 0 ? 1 : -1;  // from OpenCV's axes
    view.translation[r] = sign * camera.translation[r];
    for (size_t k = 0; k < 3; ++k) view.rotation[3 * r + k] = sign * camera.rotation[3 * r + k];
  }
  // The root's joint is at the neck, some centimetres below the face.
  double at[3];
  for (size_t r = 0; r < 3; ++r) {
    at[r] = camera.translation[r];
    for (size_t k = 0; k < 3; ++k)
      at[r] += camera.rotation[3 * r + k] * frame.params.translation[k];
  }
  const double scale = camera.fx / std::max(at[2], internal::kMinDistance);
  const double x = camera.cx + scale * at[0], y = camera.cy + scale * at[1];
  const double reach = scale * kHeadReach;
  view.box = {x - reach, y - reach, x + reach, y + reach};
  view.face_size = FaceSizeIn(frame);
  return view;
}

void TrackRefiner::FitFrame(size_t f, const std::vector<double>& near) {
  auto cost = texture_->Cost(f);
  if (!cost) return;
  double* const frame = frames_[f].data();
  ceres::Problem problem;
  problem.AddResidualBlock(cost.release(), nullptr, shape_.data(), &log_focal_, frame);
  problem.AddResidualBlock(new internal::PriorCost(given_[f], given_sigma_), nullptr, frame);
  if (!near.empty())
    problem.AddResidualBlock(new internal::PriorCost(near, step_sigma_), nullptr, frame);
  problem.SetParameterBlockConstant(shape_.data());
  problem.SetParameterBlockConstant(&log_focal_);
  internal::SolveFrame(problem, 10);
}

void TrackRefiner::FitFrames() {
  // All means are taken before any frame changes, so that the order does not matter.
  std::vector<std::vector<double>> means(frames_.size());
  const auto follows = [&](size_t f) { return track_[f]->timestep - track_[f - 1]->timestep <= 1; };
  for (size_t f = 0; f < frames_.size(); ++f)
    means[f] = internal::BetweenNeighbours(frames_, f, follows);
  tbb::parallel_for(size_t(0), frames_.size(), [&](size_t f) {
    FitFrame(f, means[f]);
    if (tick) tick();
  });
}

void TrackRefiner::Return() {
  for (size_t f = 0; f < frames_.size(); ++f) {
    for (double x : frames_[f])
      if (!std::isfinite(x)) throw Error(track_[f]->name, "could not be refined to finite numbers");
    SetFromRow(frames_[f], track_[f]->params);
  }
}

std::vector<double> TrackRefiner::Run(const std::function<Image8(const TrackedFrame&)>& image) {
  std::vector<std::optional<FrameView>> views;
  for (const TrackedFrame* frame : track_) views.push_back(ViewOf(*frame));
  const std::vector<internal::FrameFields> fields =
      internal::ReadFields(views, [&](size_t f) { return image(*track_[f]); });
  texture_.emplace(model_, int(shape_.size()), model_.expression_count, views, fields);
  const std::vector<double> spread =
      texture_->Refine(shape_, log_focal_, frames_, [&] { FitFrames(); });
  texture_.reset();
  Return();
  return spread;
}

void CheckOneLens(const TrackedVideo& video, const std::vector<TrackedFrame*>& frames) {
  const Camera& first = frames[0]->camera;
  for (size_t f = 0; f < frames.size(); ++f) {
    const Camera& camera = frames[f]->camera;
    if (f > 0 && frames[f]->timestep == frames[f - 1]->timestep)
      throw Error(video.source,
                  "frames",
                  "'" + frames[f - 1]->name + "' and '" + frames[f]->name +
                      "' show one moment by two cameras; expected one camera");
    if (camera.width != first.width || camera.height != first.height ||
        std::abs(camera.fx / first.fx - 1) > 1e-3f || std::abs(camera.fy / first.fx - 1) > 1e-3f)
      throw Error(video.source,
                  "cameras",
                  "'" + frames[f]->name + "' has another lens than '" + frames[0]->name +
                      "', or pixels that are not square");
  }
}

}  // namespace

std::vector<double> RefineTrack(const FlameModel& model,
                                TrackedVideo& video,
                                const std::function<Image8(const TrackedFrame&)>& image,
                                const std::function<void(int done, int total)>& progress) {
  std::vector<TrackedFrame*> frames = FramesInOrder(video);
  CheckOneLens(video, frames);
  FlameModel subject = model;
  for (size_t i = 0; i < video.static_offset.size() && i < subject.template_vertices.size(); ++i)
    subject.template_vertices[i] += video.static_offset[i];
  TrackRefiner refiner(subject, video, frames);
  const int total = int(frames.size()) * internal::kMaxPhotometricRounds;
  std::mutex mutex;
  int done = 0;
  refiner.tick = [&] {
    const std::lock_guard lock(mutex);
    if (progress) progress(++done, total);
  };
  const std::vector<double> spread = refiner.Run(image);
  if (progress && done < total) progress(total, total);
  return spread;
}

}  // namespace cosplat

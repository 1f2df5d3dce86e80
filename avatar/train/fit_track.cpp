#include "avatar/train/fit_track.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "avatar/math/bust.h"
#include "avatar/model/corrections.h"
#include "splat/base/error.h"
#include "splat/math/adam.h"

namespace cosplat {
namespace {

// The first step of all, in units: nothing is known of the loss yet.
constexpr double kFirstLength = 4;
// A step is taken if the loss falls by this share of what its slope promises, and is shortened for
// as long as it does not (Nocedal & Wright, algorithm 3.1).
constexpr double kShareOfSlope = 1e-4;
constexpr double kMinShare = 1e-3;

// parameters: AvatarPoser::Parameters. function(number, unit, prior), for each number of the head.
template <class Parameters, class Function>
void ForEachOfHead(Parameters& parameters, const FitSettings& s, const Function& function) {
  constexpr size_t kJaw = 2;  // and the eyes after it
  for (auto& number : parameters.expression) function(number, s.expression_unit, s.face_prior);
  for (size_t joint = 0; joint < parameters.pose.size(); ++joint)
    for (auto& number : parameters.pose[joint])
      function(number, s.pose_unit, joint < kJaw ? s.place_prior : s.face_prior);
  for (auto& number : parameters.translation) function(number, s.translation_unit, s.place_prior);
}

// The share of a step at which the parabola through a value, its slope along the step and the value
// after the step is least; within limits.
double ShorterShare(double slope, double rise) {
  const double share = -slope / (2 * (rise - slope));
  return share > 0.1 ? std::min(share, 0.5) : 0.1;
}

}  // namespace

TrackFitter::TrackFitter(const AvatarModel& model,
                         const FlameModel& flame,
                         const FitSettings& settings)
    : model_(model),
      settings_(settings),
      poser_(flame, model.shape, model.static_offset, model.bust),
      surface_(model.mesh),
      rasterizer_(MakeCpuRasterizer()),
      tape_(rasterizer_->MakeTape()) {
  if (model.embedding.released)
    throw Error("--fit-track", "is not supported with the rule of SplattingAvatar's released code");
  if (model.embedding.rigid)
    throw Error("--fit-track", "is not supported with GaussianAvatars' rule");
  gradients_.RefillLike(model_.gaussians, HostStream());
}

double TrackFitter::Prior(std::vector<double>& gradient) const {
  std::vector<float> start;
  ForEachOfHead(start_, settings_, [&](float number, float, double) { start.push_back(number); });
  gradient.clear();
  double loss = 0;
  ForEachOfHead(parameters_, settings_, [&](float number, float unit, double prior) {
    const double change = (double(number) - start[gradient.size()]) / unit;
    loss += prior * change * change;
    gradient.push_back(2 * prior * change);
  });
  return loss;
}

double TrackFitter::Draw() {
  poser_.Forward(parameters_, vertices_);
  surface_.Pose(vertices_);
  Bind(model_, surface_, posed_, CorrectionWeights(model_.correction_map, parameters_));
  rasterizer_->Forward(PosedView(model_.gaussians, posed_, model_.color_frame),
                       model_.gaussians.basis,
                       camera_,
                       {background_, model_.gaussians.degree},
                       image_,
                       *tape_);
  return loss_.Evaluate({}, image_.color, *target_, background_, d_color_) + Prior(d_prior_);
}

double TrackFitter::LossOf(const TrackedFrame& frame,
                           const Image8& target,
                           const std::array<float, 3>& background) {
  camera_ = frame.camera, target_ = &target, background_ = background;
  parameters_ = poser_.ParametersFor(frame.params);
  parameters_.expression.resize(size_t(poser_.flame().model().expression_count), 0.0f);
  start_ = parameters_;
  return Draw();
}

void TrackFitter::Fit(const TrackedFrame& frame,
                      const Image8& target,
                      const std::array<float, 3>& background) {
  double loss = LossOf(frame, target, background);
  bool drawn = true;  // the image is that of parameters_
  std::vector<double> gradient = Gradient();
  for (int draws = 1; draws < settings_.draws;) {
    const AvatarPoser::Parameters from = parameters_;
    std::vector<double> step = lbfgs_.StepAt(gradient, kFirstLength);
    const double slope = std::inner_product(step.begin(), step.end(), gradient.begin(), 0.0);
    drawn = false;
    double share = 1;
    while (slope < 0 && share > kMinShare && draws < settings_.draws) {
      parameters_ = Moved(from, step, share);
      const double trial = Draw();
      ++draws;
      drawn = trial <= loss + kShareOfSlope * share * slope;
      if (drawn) {
        loss = trial;
        break;
      }
      share *= ShorterShare(share * slope, trial - loss);
    }
    if (!drawn) {
      parameters_ = from;
      if (lbfgs_.knows_nothing()) break;
      lbfgs_.Forget();
    } else if (draws < settings_.draws) {
      std::vector<double> change = Gradient();
      gradient.swap(change);
      for (size_t i = 0; i < change.size(); ++i) {
        step[i] *= share;
        change[i] = gradient[i] - change[i];
      }
      lbfgs_.Learn(std::move(step), std::move(change));
    }
  }
  if (!drawn) Draw();
}

std::vector<double> TrackFitter::Gradient() {
  d_posed_.Resize(model_.size());
  WorldGradients d = GradientViewOf(gradients_, screen_);
  d.position = d_posed_.position.data();
  d.rotation = d_posed_.rotation.data();
  d.scale_log = d_posed_.scale_log.data();
  if (model_.color_frame == ColorFrame::kSurface) {
    d.color_frame = d_posed_.frame.data();
  } else {
    d_posed_.frame.clear();
  }
  rasterizer_->Backward(
      PosedView(model_.gaussians, posed_, model_.color_frame), image_, d_color_, *tape_, d);
  const std::vector<float> weights = CorrectionWeights(model_.correction_map, parameters_);
  BindBackward(model_.gaussians,
               model_.embedding,
               surface_,
               d_posed_,
               gradients_,
               &d_vertices_,
               scratch_,
               AppearanceOf(model_, weights));
  std::vector<double> numbers;
  const AvatarPoser::Parameters d_head = poser_.Backward(parameters_, d_vertices_);
  if (settings_.head)
    ForEachOfHead(d_head, settings_, [&](float d_number, float unit, double) {
      numbers.push_back(unit * math::UsableGradient(d_number) + d_prior_[numbers.size()]);
    });
  if (settings_.bust && !poser_.bust().empty()) {
    math::Vec3<float> d_turn{0, 0, 0}, d_shift{0, 0, 0};
    for (size_t i = vertices_.size() - poser_.bust().size(); i < vertices_.size(); i += 3)
      math::MoveWithBustVjp(parameters_.bust,
                            poser_.bust_pivot(),
                            {vertices_[i], vertices_[i + 1], vertices_[i + 2]},
                            {d_vertices_[i], d_vertices_[i + 1], d_vertices_[i + 2]},
                            d_turn,
                            d_shift);
    for (const float d_number : {d_turn.x, d_turn.y, d_turn.z})
      numbers.push_back(settings_.pose_unit * math::UsableGradient(d_number));
    for (const float d_number : {d_shift.x, d_shift.y, d_shift.z})
      numbers.push_back(settings_.translation_unit * math::UsableGradient(d_number));
  }
  return numbers;
}

AvatarPoser::Parameters TrackFitter::Moved(const AvatarPoser::Parameters& from,
                                           const std::vector<double>& step,
                                           double share) const {
  AvatarPoser::Parameters to = from;
  const double* next = step.data();
  if (settings_.head)
    ForEachOfHead(to, settings_, [&](float& number, float unit, double) {
      number += float(share * *next++ * unit);
    });
  if (settings_.bust && !poser_.bust().empty()) {
    const auto three = [&](float unit) {
      const auto number = [&] { return float(share * *next++ * unit); };
      return math::Vec3<float>{number(), number(), number()};
    };
    to.bust.turn = math::TurnedBy(three(settings_.pose_unit), from.bust.turn);
    to.bust.shift += three(settings_.translation_unit);
  }
  return to;
}

}  // namespace cosplat

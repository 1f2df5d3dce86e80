#include "avatar/train/fit_track.h"

#include <cmath>

#include "avatar/math/bust.h"
#include "avatar/model/corrections.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr double kLastRate = 0.05;

}  // namespace

TrackFitter::TrackFitter(const AvatarModel& model, const FlameModel& flame)
    : model_(model),
      poser_(flame, model.shape, model.static_offset, model.bust),
      surface_(model.mesh),
      rasterizer_(MakeCpuRasterizer()),
      tape_(rasterizer_->MakeTape()) {
  if (model.embedding.released)
    throw Error("--fit-track", "is not supported with the rule of SplattingAvatar's released code");
  if (model.embedding.rigid)
    throw Error("--fit-track", "is not supported with GaussianAvatars' rule");
}

void TrackFitter::Draw(const Camera& camera, const std::array<float, 3>& background) {
  poser_.Forward(frame_.params, vertices_);
  surface_.Pose(vertices_);
  Bind(model_, surface_, posed_, CorrectionWeights(model_.correction_map, frame_.params));
  rasterizer_->Forward(PosedView(model_.gaussians, posed_, model_.color_frame),
                       model_.gaussians.basis,
                       camera,
                       {background, model_.gaussians.degree},
                       image_,
                       *tape_);
}

void TrackFitter::Begin(const TrackedFrame& frame) {
  frame_ = {poser_.ParametersFor(frame.params), size_t(poser_.flame().model().expression_count)};
  bust_ = {};
}

double TrackFitter::LossOf(const TrackedFrame& frame,
                           const Image8& target,
                           const std::array<float, 3>& background) {
  Begin(frame);
  Draw(frame.camera, background);
  return loss_.Evaluate({}, image_.color, target, background, d_color_);
}

void TrackFitter::Fit(const TrackedFrame& frame,
                      const Image8& target,
                      const std::array<float, 3>& background,
                      const FitSettings& settings) {
  Begin(frame);
  gradients_.RefillLike(model_.gaussians, HostStream());
  AvatarPoser::Parameters best = frame_.params;
  double min = HUGE_VAL;
  for (int step = 1; step <= settings.steps; ++step) {
    Draw(frame.camera, background);
    const double loss = loss_.Evaluate({}, image_.color, target, background, d_color_);
    if (loss < min) {
      min = loss;
      best = frame_.params;
    }
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
    const std::vector<float> weights = CorrectionWeights(model_.correction_map, frame_.params);
    BindBackward(model_.gaussians,
                 model_.embedding,
                 surface_,
                 d_posed_,
                 gradients_,
                 &d_vertices_,
                 scratch_,
                 AppearanceOf(model_, weights));
    Step(settings, step);
  }
  frame_.params = best;
  Draw(frame.camera, background);
}

void TrackFitter::Step(const FitSettings& settings, int step) {
  AvatarPoser::Parameters& parameters = frame_.params;
  const AvatarPoser::Parameters gradient = poser_.Backward(parameters, d_vertices_);
  const double share = std::pow(kLastRate, double(step) / settings.steps);
  const TrackRates rates{float(share * settings.expression_rate),
                         float(share * settings.pose_rate),
                         float(share * settings.translation_rate)};
  if (settings.head) frame_.Step(gradient, rates);
  if (!settings.bust || poser_.bust().empty()) return;
  math::Vec3<float> turn{0, 0, 0}, shift{0, 0, 0}, d_turn{0, 0, 0}, d_shift{0, 0, 0};
  for (size_t i = vertices_.size() - poser_.bust().size(); i < vertices_.size(); i += 3)
    math::MoveWithBustVjp(parameters.bust,
                          poser_.bust_pivot(),
                          {vertices_[i], vertices_[i + 1], vertices_[i + 2]},
                          {d_vertices_[i], d_vertices_[i + 1], d_vertices_[i + 2]},
                          d_turn,
                          d_shift);
  const math::AdamStep turns = math::AdamStepAt(rates.pose, step);
  bust_.Update(turns, 0, d_turn.x, turn.x);
  bust_.Update(turns, 1, d_turn.y, turn.y);
  bust_.Update(turns, 2, d_turn.z, turn.z);
  const math::AdamStep shifts = math::AdamStepAt(rates.translation, step);
  bust_.Update(shifts, 3, d_shift.x, shift.x);
  bust_.Update(shifts, 4, d_shift.y, shift.y);
  bust_.Update(shifts, 5, d_shift.z, shift.z);
  parameters.bust.turn = math::TurnedBy(turn, parameters.bust.turn);
  parameters.bust.shift += shift;
}

}  // namespace cosplat

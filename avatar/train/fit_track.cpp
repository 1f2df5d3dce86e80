#include "avatar/train/fit_track.h"

#include <cmath>

#include "avatar/math/bust.h"
#include "avatar/model/corrections.h"
#include "splat/base/error.h"
#include "splat/math/adam.h"

namespace cosplat {
namespace {

constexpr double kEps = 1e-15;
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
  poser_.Forward(parameters_, vertices_);
  surface_.Pose(vertices_);
  Bind(model_, surface_, posed_, CorrectionWeights(model_.correction_map, parameters_));
  rasterizer_->Forward(PosedView(model_.gaussians, posed_, model_.color_frame),
                       model_.gaussians.basis,
                       camera,
                       {background, model_.gaussians.degree},
                       image_,
                       *tape_);
}

void TrackFitter::Fit(const TrackedFrame& frame,
                      const Image8& target,
                      const std::array<float, 3>& background,
                      const FitSettings& settings) {
  poser_.ParametersFor(frame.params, parameters_);
  parameters_.expression.resize(size_t(poser_.flame().model().expression_count), 0.0f);
  moments_.assign(2 * (parameters_.expression.size() + 3 * kFlameJoints + 3 + 6), 0.0f);
  gradients_.RefillLike(model_.gaussians, HostStream());
  AvatarPoser::Parameters best = parameters_;
  double least = HUGE_VAL;
  for (int step = 1; step <= settings.steps; ++step) {
    Draw(frame.camera, background);
    const double loss = loss_.Evaluate({}, image_.color, target, background, d_color_);
    if (loss < least) {
      least = loss;
      best = parameters_;
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
    const std::vector<float> weights = CorrectionWeights(model_.correction_map, parameters_);
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
  parameters_ = best;
  Draw(frame.camera, background);
}

void TrackFitter::Step(const FitSettings& settings, int step) {
  const AvatarPoser::Parameters gradient = poser_.Backward(parameters_, d_vertices_);
  const double share = std::pow(kLastRate, double(step) / settings.steps);
  size_t next = 0;
  const size_t numbers = moments_.size() / 2;
  const auto update = [&](float g, float& value, float rate) {
    const math::AdamStep adam = math::AdamStepAt(float(share * rate), kEps, step);
    math::AdamUpdate(
        adam, std::isfinite(g) ? g : 0.0f, value, moments_[next], moments_[numbers + next]);
    ++next;
  };
  if (settings.head) {
    for (size_t k = 0; k < gradient.expression.size(); ++k)
      update(gradient.expression[k], parameters_.expression[k], settings.expression_rate);
    for (size_t j = 0; j < kFlameJoints; ++j)
      for (size_t k = 0; k < 3; ++k)
        update(gradient.pose[j][k], parameters_.pose[j][k], settings.pose_rate);
    for (size_t k = 0; k < 3; ++k)
      update(gradient.translation[k], parameters_.translation[k], settings.translation_rate);
  }
  if (!settings.bust || poser_.bust().empty()) return;
  math::Vec3<float> turn{0, 0, 0}, shift{0, 0, 0}, d_turn{0, 0, 0}, d_shift{0, 0, 0};
  for (size_t i = vertices_.size() - poser_.bust().size(); i < vertices_.size(); i += 3)
    math::MoveWithBustVjp(parameters_.bust,
                          poser_.bust_pivot(),
                          {vertices_[i], vertices_[i + 1], vertices_[i + 2]},
                          {d_vertices_[i], d_vertices_[i + 1], d_vertices_[i + 2]},
                          d_turn,
                          d_shift);
  update(d_turn.x, turn.x, settings.pose_rate);
  update(d_turn.y, turn.y, settings.pose_rate);
  update(d_turn.z, turn.z, settings.pose_rate);
  update(d_shift.x, shift.x, settings.translation_rate);
  update(d_shift.y, shift.y, settings.translation_rate);
  update(d_shift.z, shift.z, settings.translation_rate);
  parameters_.bust.turn = math::TurnedBy(turn, parameters_.bust.turn);
  parameters_.bust.shift += shift;
}

}  // namespace cosplat

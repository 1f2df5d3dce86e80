#include "avatar/train/trainer.h"

#include <cmath>

#include "avatar/model/trained_range.h"
#include "avatar/play/player.h"
#include "splat/math/adam.h"

namespace cosplat {
namespace {

// SplattingAvatar, in units of a FLAME mesh enlarged so many times.
constexpr float kEnlarged = 4;
constexpr float kSplitScale = 0.02f;
constexpr float kMaxScale = 0.2f;
constexpr float kNeedleScale = 0.008f;

template <class F>
void ForEachNumber(AvatarPoser::Frame& a, const F& f) {
  for (size_t k = 0; k < a.expression.size(); ++k) f(0, k, a.expression[k]);
  for (size_t j = 0; j < a.pose.size(); ++j)
    for (size_t k = 0; k < 3; ++k) f(1, 3 * j + k, a.pose[j][k]);
  for (size_t k = 0; k < 3; ++k) f(2, k, a.translation[k]);
}

float* NumberOf(AvatarPoser::Frame& a, int group, size_t k) {
  if (group == 0) return &a.expression[k];
  return group == 1 ? &a.pose[k / 3][k % 3] : &a.translation[k];
}

}  // namespace

void ScaleToUnit(float unit, TrainSettings& settings) {
  settings.density.split_scale = kSplitScale * unit;
  settings.density.max_scale = kMaxScale * unit;
  settings.scale_regularizer.limit = kNeedleScale * unit;
  settings.scale_regularizer.weight /= unit;
}

AvatarSubject::~AvatarSubject() = default;

AvatarModel AvatarSubject::Model(const Gaussians& gaussians) const {
  AvatarModel model;
  static_cast<Embedding&>(model) = state_.embedding;
  model.mesh = mesh_;
  model.canonical_frame = canonical_frame_;
  model.gaussians = gaussians;
  model.bust = bust_;
  model.color_frame = settings_.color_frame;
  model.flame_name = flame_.name;
  model.flame_sha256 = flame_.sha256;
  model.shape = video_.shape;
  model.static_offset = video_.static_offset;
  model.trained_range = RangeOf(RefinedTrack());
  return model;
}

double AvatarSubject::WalkedShare() const {
  size_t walked = 0;
  for (size_t i = 0; i < state_.first_triangle.size(); ++i)
    walked += state_.embedding.triangle[i] != state_.first_triangle[i];
  return state_.first_triangle.empty() ? 0 : double(walked) / double(state_.first_triangle.size());
}

std::vector<FlameParams> AvatarSubject::RefinedTrack() const {
  std::vector<FlameParams> track;
  for (const RefinedFrame& frame : state_.track) {
    FlameParams p;
    p.expression = frame.params.expression;
    p.pose = frame.params.pose;
    p.translation = frame.params.translation;
    track.push_back(p);
  }
  return track;
}

const std::vector<float>& AvatarSubject::VerticesOf(size_t i) {
  current_ = i;
  poser_->Forward(state_.track[i].params, vertices_);
  return vertices_;
}

void AvatarSubject::PoseFrame(size_t i) {
  poser_->Forward(state_.track[i].params, vertices_);
  surface_.Pose(vertices_);
}

WorldGaussians AvatarSubject::Place(const Gaussians& gaussians, size_t i) {
  current_ = i;
  PoseFrame(i);
  Bind(gaussians, state_.embedding, surface_, posed_);
  return PosedView(gaussians, posed_, settings_.color_frame);
}

WorldGradients AvatarSubject::WorldGradientsFor(Gaussians& gradients, Buffer<float>& screen) {
  d_posed_.Resize(gradients.size());
  WorldGradients view = GradientViewOf(gradients, screen);
  view.position = d_posed_.position.data();
  view.rotation = d_posed_.rotation.data();
  view.scale_log = d_posed_.scale_log.data();
  if (settings_.color_frame == ColorFrame::kSurface) {
    view.color_frame = d_posed_.frame.data();
  } else {
    d_posed_.frame.clear();
  }
  return view;
}

void AvatarSubject::PlaceBackward(const Gaussians& gaussians, Gaussians& gradients) {
  BindBackward(gaussians,
               state_.embedding,
               surface_,
               d_posed_,
               gradients,
               settings_.refine_track ? &d_vertices_ : nullptr);
  if (settings_.refine_track) RefineFrame(d_vertices_);
}

// One Adam step on the current frame's own parameters.
void AvatarSubject::RefineFrame(const std::vector<float>& d_vertices) {
  RefinedFrame& frame = state_.track[current_];
  Frame gradient = poser_->Backward(frame.params, d_vertices);
  gradient.expression.resize(frame.params.expression.size(), 0.0f);
  const float rates[3] = {settings_.expression_rate,
                          settings_.pose_rate,
                          settings_.translation_rate * kEnlarged * unit_};
  ++frame.step;
  math::AdamStep step;
  const double c1 = 1 - std::pow(double(step.beta1), double(frame.step));
  const double c2 = std::sqrt(1 - std::pow(double(step.beta2), double(frame.step)));
  constexpr double kEps = 1e-15;
  step.scaled_eps = float(kEps * c2);
  ForEachNumber(gradient, [&](int group, size_t k, float g) {
    step.step_size = float(rates[group] * c2 / c1);
    math::AdamUpdate(step,
                     std::isfinite(g) ? g : 0.0f,
                     *NumberOf(frame.params, group, k),
                     *NumberOf(frame.m, group, k),
                     *NumberOf(frame.v, group, k));
  });
}

View<const float> AvatarSubject::PositionRateScale() {
  rate_scale_.resize(3 * state_.embedding.triangle.size());
  for (size_t i = 0; i < state_.embedding.triangle.size(); ++i) {
    rate_scale_[3 * i] = rate_scale_[3 * i + 1] = face_rates_[state_.embedding.triangle[i]];
    rate_scale_[3 * i + 2] = 1;
  }
  return rate_scale_;
}

void AvatarSubject::SetPlaces(Embedding embedding, std::vector<int32_t> first_triangle) {
  state_.embedding = std::move(embedding);
  state_.first_triangle = std::move(first_triangle);
}

void AvatarSubject::AfterStep(int iteration, Gaussians& gaussians, AdamState& adam) {
  if (iteration % settings_.walk_every != 0) return;
  const WalkReport report = WalkAll(gaussians, state_.embedding, surface_);
  for (const auto* list : {&report.crossed, &report.stopped_at_boundary, &report.invalid})
    for (const uint32_t i : *list)
      for (Gaussians* moments : {&adam.m, &adam.v})
        moments->at(kPosition, i)[0] = moments->at(kPosition, i)[1] = 0;
}

}  // namespace cosplat

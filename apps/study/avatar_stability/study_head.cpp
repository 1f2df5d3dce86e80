#include "apps/study/avatar_stability/study_head.h"

#include <algorithm>
#include <cmath>

#include "assets/head/motion.h"
#include "avatar/play/player.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr size_t kPainted = 15000;
constexpr float kWider = 1.6f;      // than painted, so that the head has no holes
constexpr float kDistance = 0.85f;  // camera distance, metres
constexpr float kMinDeviation = 0.1f;

}  // namespace

StudyHead::StudyHead()
    : head(MakeProceduralHeadParts()),
      avatar(PaintedAvatar(head, kPainted, 0)),
      poser(head.model, {}) {
  for (float& s : avatar.gaussians.values[kScaleLog]) s += std::log(kWider);
}

std::vector<float> StudyHead::Vertices(const FlameParams& params) const {
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(params), vertices);
  return vertices;
}

Camera StudyCamera(float azimuth) {
  return procedural::OrbitCamera(azimuth, 0, kDistance, kStudyImage);
}

ExpressionRange RangeOfExpressions() {
  const std::vector<procedural::ScriptFrame> script = procedural::MakeScript({});
  ExpressionRange range;
  range.mean.assign(kExpressionCount, 0.0f);
  range.deviation.assign(kExpressionCount, 0.0f);
  const float share = 1.0f / float(script.size());
  for (int k = 0; k < kExpressionCount; ++k) {
    const auto coefficient = [&](const procedural::ScriptFrame& frame) {
      return size_t(k) < frame.params.expression.size() ? frame.params.expression[k] : 0.0f;
    };
    for (const auto& frame : script) range.mean[k] += share * coefficient(frame);
    float square = 0;
    for (const auto& frame : script) {
      const float d = coefficient(frame) - range.mean[k];
      square += share * d * d;
    }
    range.deviation[k] = std::max(kMinDeviation, std::sqrt(square));
  }
  return range;
}

FlameParams Grimace() {
  constexpr int kJaw = 2;
  FlameParams params;
  params.expression.assign(kExpressionCount, 0.0f);
  for (const Expression e : {Expression::kCheekPuff,
                             Expression::kBrowUp,
                             Expression::kLipsApart,
                             Expression::kSmileLeft})
    params.expression[int(e)] = 1;
  params.pose[kJaw][0] = 0.35f;  // radians
  return params;
}

float LargestScale(const PosedGaussians& posed, size_t i) {
  const float* s = &posed.scale_log[3 * i];
  return std::exp(std::max({s[0], s[1], s[2]}));
}

BoundBothWays::BoundBothWays(const AvatarModel& avatar, float unit) : surface_(avatar.mesh) {
  naive.model = ours.model = avatar;
  naive.model.embedding.released = ReleasedRule{unit};
  naive.model.light.reset();  // which that rule does not have
  Pose(avatar.mesh.vertices);
}

BoundBothWays::BoundBothWays(const AvatarModel& avatar)
    : BoundBothWays(avatar, MeshUnit(avatar.mesh)) {}

void BoundBothWays::Pose(const std::vector<float>& vertices) {
  surface_.Pose(vertices);
  for (Way* way : {&naive, &ours}) Bind(way->model, surface_, way->posed);
}

RenderedImage DrawOver(const BoundBothWays::Way& way,
                       const Camera& camera,
                       const std::array<float, 3>& background) {
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  RenderedImage image;
  rasterizer->Forward(PosedView(way.model.gaussians, way.posed, way.model.color_frame),
                      way.model.gaussians.basis,
                      camera,
                      {background, way.model.gaussians.degree},
                      image,
                      *tape);
  return image;
}

Image8 ImageOf(const BoundBothWays::Way& way, const Camera& camera) {
  return ToBytes(DrawOver(way, camera, {1, 1, 1}).ToImage());
}

}  // namespace cosplat

#include "avatar/play/player.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "avatar/model/corrections.h"
#include "avatar/play/image_bytes.h"
#include "avatar/play/preview.h"
#include "splat/base/error.h"
#include "splat/gaussians.h"

namespace cosplat {
namespace {

// Compares bits, not values (-0 == 0, NaN != NaN), so that reused images are bit-identical to those
// of a new player.
bool SameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}
template <class T>
bool SameBits(const T& a, const T& b) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(float) == 0);
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

void SortAvatar(AvatarModel& avatar) {
  const size_t n = avatar.size();
  if (avatar.embedding.triangle.size() != n || avatar.embedding.barycentric.size() != n)
    return;  // Bind throws in this case
  const std::vector<uint32_t> order = SortByDegree(avatar.gaussians);
  if (order.empty()) return;
  const Embedding before = avatar.embedding;
  for (size_t i = 0; i < order.size(); ++i) {
    avatar.embedding.triangle[i] = before.triangle[order[i]];
    avatar.embedding.barycentric[i] = before.barycentric[order[i]];
  }
}

}  // namespace

bool PosedAvatar::IsFor(const FlameParams& params) const {
  return id_ != 0 && SameBits(params.expression, params_.expression) &&
         SameBits(params.pose, params_.pose) && SameBits(params.translation, params_.translation);
}

Player::Player(AvatarModel avatar, const FlameModel& flame, PlayerSettings settings)
    : avatar_(std::move(avatar)),
      half_resolution_(settings.half_resolution),
      poser_(flame, avatar_.shape, avatar_.static_offset, avatar_.bust),
      surface_(avatar_.mesh),
      rasterizer_(MakeCpuRasterizer()),
      tape_(rasterizer_->MakeTape()) {
  SortAvatar(avatar_);
  if (surface_.vertex_count() != poser_.vertex_count())
    throw Error(flame.name,
                "vertices",
                "the model has " + std::to_string(poser_.vertex_count()) +
                    " vertices, the avatar's mesh " + std::to_string(surface_.vertex_count()));
  if (!settings.make_renderer) return;
  CheckEmbedding(avatar_.gaussians, avatar_.embedding, surface_.faces().size());
  const AvatarPosing posing{poser_.flame().Arrays(), poser_.bust(), poser_.bust_pivot()};
  reach_.emplace(posing.flame);
  renderer_ = settings.make_renderer(avatar_, posing);
}

void Player::Pose(const FlameParams& params, PosedAvatar& out) {
  if (out.IsFor(params)) return;
  poser_.ParametersFor(params, frame_);
  if (renderer_)
    Prepare(out);
  else
    PoseAndBind(out);
  out.params_.expression = params.expression;
  out.params_.pose = params.pose;
  out.params_.translation = params.translation;
  out.id_ = ++last_id_;
  if (!renderer_) out.posed_id_ = out.bound_id_ = out.id_;
}

void Player::PoseAndBind(PosedAvatar& placed) {
  poser_.Forward(frame_, placed.vertices_);  // throws before it writes
  placed.id_ = 0;
  BindInto(placed);
}

void Player::Prepare(PosedAvatar& placed) {
  poser_.flame().Prepare(frame_, rig_.flame);
  reach_->Check(rig_.flame);
  rig_.bust = frame_.bust;
  CorrectionWeights(avatar_.correction_map, frame_, rig_.weights);
  std::swap(placed.rig_, rig_);
}

void Player::BindInto(PosedAvatar& placed) {
  surface_.Pose(placed.vertices_);
  CorrectionWeights(avatar_.correction_map, frame_, weights_);
  Bind(avatar_, surface_, placed.gaussians_, weights_);
}

const std::vector<float>& Player::VerticesOf(PosedAvatar& placed) {
  if (placed.posed_id_ != placed.id_) {
    poser_.ParametersFor(placed.params_, frame_);
    poser_.Forward(frame_, placed.vertices_);
    placed.posed_id_ = placed.id_;
  }
  return placed.vertices_;
}

const PosedGaussians& Player::GaussiansOf(PosedAvatar& placed) {
  if (placed.bound_id_ != placed.id_) {
    VerticesOf(placed);
    poser_.ParametersFor(placed.params_, frame_);  // the last Pose may have been of another
    BindInto(placed);
    placed.bound_id_ = placed.id_;
  }
  return placed.gaussians_;
}

const RenderedImage& Player::Draw(const PosedAvatar& placed,
                                  const Camera& camera,
                                  const std::array<float, 3>& background) {
  if (placed.id_ == 0) throw Error("avatar", "placed", "was not placed before rendering");
  if (last_.id == placed.id_ && SameBits(last_.camera, camera) &&
      SameBits(last_.background, background))
    return last_.image;
  last_.id = 0;
  const bool half = half_resolution_;
  DrawInto(placed,
           half ? HalfResolution(camera) : camera,
           {background, avatar_.gaussians.degree},
           half ? half_ : last_.image);
  if (half) EnlargeTwice(half_, camera.width, camera.height, last_.image);
  last_.camera = camera;
  last_.background = background;
  last_.id = placed.id_;
  return last_.image;
}

void Player::DrawToStay(const PosedAvatar& placed,
                        const Camera& camera,
                        const std::array<float, 3>& background,
                        AlphaMode alpha,
                        std::unique_ptr<DeviceImage>& out) {
  if (placed.id_ == 0) throw Error("avatar", "placed", "was not placed before rendering");
  if (!DrawsOnDevice()) throw Error("avatar", "image", "cannot stay: no device draws it");
  renderer_->DrawToStay(
      placed.rig_, placed.id_, camera, {background, avatar_.gaussians.degree}, alpha, out);
}

void Player::DrawInto(const PosedAvatar& placed,
                      const Camera& camera,
                      const RenderSettings& settings,
                      RenderedImage& image) {
  if (renderer_) return renderer_->Draw(placed.rig_, placed.id_, camera, settings, image);
  rasterizer_->Forward(PosedView(avatar_.gaussians, placed.gaussians_, avatar_.color_frame),
                       avatar_.gaussians.basis,
                       camera,
                       settings,
                       image,
                       *tape_);
}

void Player::RenderOver(const FlameParams& params,
                        const Camera& camera,
                        const std::array<float, 3>& background,
                        RenderedImage& out) {
  Pose(params, placed_);
  out = Draw(placed_, camera, background);
}

void Player::Render(const FlameParams& params, const Camera& camera, Image8& out) {
  Pose(params, placed_);
  ToStraightAlphaBytes(Draw(placed_, camera, {0, 0, 0}), out);
}

Image8 Player::Render(const FlameParams& params, const Camera& camera) {
  Image8 out;
  Render(params, camera, out);
  return out;
}

void ToStraightAlphaBytes(const RenderedImage& image, Image8& out) {
  out.width = image.width;
  out.height = image.height;
  out.channels = 4;
  out.data.resize(4 * out.pixels());
  WriteImageBytes(image, {}, out.data.data(), 4 * ptrdiff_t(out.width));
}

}  // namespace cosplat

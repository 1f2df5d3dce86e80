#include "avatar/plugin/instance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "avatar/io/avatar_file.h"
#include "avatar/model/avatar_mesh.h"
#include "avatar/model/bust.h"
#include "avatar/play/avatar_renderer.h"
#include "avatar/play/image_bytes.h"
#include "avatar/plugin/coded_error.h"
#include "flame/model.h"
#include "splat/base/text.h"

namespace cosplat::plugin {
namespace {

// Larger than any image needs: a larger stride means that it was not initialised.
constexpr int64_t kMaxStride = int64_t(1) << 32;

FlameModel ReadFlame(const char* avatar_path, const char* flame_path, const AvatarModel& avatar) {
  try {
    return LoadFlameOf(avatar, avatar_path, flame_path ? flame_path : "", "flame_path");
  } catch (const Error& error) {
    throw CodedError(COSPLAT_ERROR_FLAME, error.what());
  }
}

// AUTO is the CPU until the device's parity tests have run on a GPU.
AvatarRendererMaker RendererFor(uint32_t device) {
  if (device == COSPLAT_DEVICE_AUTO || device == COSPLAT_DEVICE_CPU) return {};
  if (device != COSPLAT_DEVICE_CUDA)
    Refuse("device", std::to_string(device) + " is not a COSPLAT_DEVICE_ value");
  try {
    return AvatarRendererOn(UsableDevice(Device::kCuda, "device"));
  } catch (const Error& error) {
    throw CodedError(COSPLAT_ERROR_DEVICE, error.what());
  }
}

Player MakePlayer(AvatarModel avatar,
                  const FlameModel& flame,
                  AvatarRendererMaker make_renderer,
                  uint32_t bust) {
  if (bust > COSPLAT_BUST_STILL) Refuse("bust", Format("{} is not a COSPLAT_BUST_ value", bust));
  try {
    AttachMesh(avatar, flame);
    if (bust == COSPLAT_BUST_STILL) HoldBustStill(avatar);
    return Player(std::move(avatar), flame, {false, std::move(make_renderer)});
  } catch (const Error& error) {
    throw CodedError(COSPLAT_ERROR_FLAME, error.what());
  }
}

cosplat_info InfoOf(const AvatarModel& avatar,
                    const FlameModel& flame,
                    const PosedGaussians& rest) {
  cosplat_info info{};
  info.gaussian_count = uint32_t(avatar.size());
  info.triangle_count = uint32_t(avatar.mesh.faces.size());
  info.expression_count = uint32_t(flame.expression_count);
  info.joint_count = kFlameJoints;
  const Buffer<float>& position = rest.position;
  for (size_t i = 0; i < position.size(); ++i) {
    float &min = info.box_min[i % 3], &max = info.box_max[i % 3];
    min = i < 3 ? position[i] : std::min(min, position[i]);
    max = i < 3 ? position[i] : std::max(max, position[i]);
  }
  std::copy(avatar.background.begin(), avatar.background.end(), info.background);
  if (!avatar.filmed) return info;
  info.knows_filmed = 1;
  std::copy_n(avatar.filmed->yaw.begin(), 2, info.filmed_yaw);
  std::copy_n(avatar.filmed->pitch.begin(), 2, info.filmed_pitch);
  return info;
}

// Replaces 0 by the default stride. Throws if the stride is shorter than a row or not a multiple of
// `step`.
ptrdiff_t CheckedStride(int64_t stride, uint32_t width, int64_t step, const char* field) {
  const int64_t row = 4 * int64_t(width);
  if (stride == 0) return ptrdiff_t(row);
  if (stride < -kMaxStride || stride > kMaxStride || std::abs(stride) < row || stride % step != 0)
    Refuse(field,
           std::to_string(stride) + " bytes; its magnitude must be at least " +
               std::to_string(row) + (step > 1 ? " and a multiple of 4" : ""));
  return ptrdiff_t(stride);
}

void CheckChoice(uint32_t value, uint32_t max, const char* field) {
  if (value > max) Refuse(field, Format("{} is not from 0 to {}", value, max));
}

void CheckPicture(const cosplat_picture& picture) {
  CheckSize(picture.width, picture.height, "picture");
  CheckChoice(picture.format, COSPLAT_FORMAT_BGRA8, "picture.format");
  CheckChoice(picture.alpha, COSPLAT_ALPHA_OPAQUE, "picture.alpha");
  if (!picture.pixels) Refuse("picture.pixels", "is NULL");
  if (reinterpret_cast<uintptr_t>(picture.depth) % alignof(float) != 0)
    Refuse("picture.depth", "is not aligned to 4 bytes");
  if (picture.alpha != COSPLAT_ALPHA_OPAQUE) return;
  for (const float x : picture.background)
    if (!(x >= 0 && x <= 1)) Refuse("picture.background", Format("{} is not from 0 to 1", x));
}

}  // namespace

Instance::Instance(const char* avatar_path, const cosplat_open_options& options)
    : player_([&] {
        AvatarRendererMaker make_renderer = RendererFor(options.device);
        AvatarModel avatar = ReadAvatarGlb(avatar_path);
        flame_ = ReadFlame(avatar_path, options.flame_path, avatar);
        return MakePlayer(std::move(avatar), flame_, std::move(make_renderer), options.bust);
      }()),
      rest_(RestRoot(player_.avatar(), flame_)),
      parameters_(size_t(flame_.expression_count), rest_),
      face_(parameters_.rest(), flame_, player_.avatar()) {
  player_.Pose(parameters_.current(), placed_);
  info_ = InfoOf(player_.avatar(), flame_, player_.GaussiansOf(placed_));
  // The head alone, whose vertices come before those of the bust.
  head_place_ = PlaceOfHead({player_.VerticesOf(placed_).data(), 3 * size_t(flame_.vertex_count)},
                            rest_.pose[0]);
  for (int i = 0; i < flame_.expression_count; ++i)
    expression_names_.push_back("expression_" + std::to_string(i));
}

Camera Instance::CameraFor(const cosplat_picture& picture) const {
  if (!camera_) return OrbitCamera(head_place_, picture.width, picture.height, {});
  if (uint32_t(camera_->width) != picture.width || uint32_t(camera_->height) != picture.height)
    Refuse("picture.width, height",
           SizeText(picture.width, picture.height) + ", the camera has " +
               SizeText(camera_->width, camera_->height));
  return *camera_;
}

void Instance::ResetParameters() {
  parameters_.Reset();
  face_.Reset();
}

void Instance::SetDrive(const char* drive) {
  face_.SetDrive(drive);
  parameters_.ForgetTime();
}

const FlameParams& Instance::Face() const {
  return face_.shown() ? *face_.shown() : parameters_.current();
}

void Instance::Pose() { player_.Pose(Face(), placed_); }

cosplat_health Instance::Health() {
  cosplat_health health = face_.Health();
  health.beyond_film = beyond_film_;
  return health;
}

WorldGaussians Instance::Placed() {
  Pose();
  const AvatarModel& avatar = player_.avatar();
  return PosedView(avatar.gaussians, player_.GaussiansOf(placed_), avatar.color_frame);
}

void Instance::Render(const cosplat_picture& picture) {
  CheckPicture(picture);
  const ptrdiff_t stride = CheckedStride(picture.stride, picture.width, 1, "picture.stride");
  const ptrdiff_t depth_stride =
      CheckedStride(picture.depth_stride, picture.width, 4, "picture.depth_stride");
  const Camera camera = CameraFor(picture);
  std::array<float, 3> background{};
  if (picture.alpha == COSPLAT_ALPHA_OPAQUE) std::copy_n(picture.background, 3, background.begin());

  // Both images are rendered before anything is written, so that a failure writes nothing.
  Pose();
  const RenderedImage& image = player_.Draw(placed_, camera, background);
  if (picture.depth) {
    if (!depth_) depth_.emplace();
    const RenderedImage& depth =
        depth_->Draw(player_.avatar(), player_.GaussiansOf(placed_), camera);
    WriteDepth(depth, picture.depth, depth_stride);
  }
  const PixelLayout layout{static_cast<AlphaMode>(picture.alpha),
                           picture.format == COSPLAT_FORMAT_BGRA8};
  WriteImageBytes(image, layout, static_cast<uint8_t*>(picture.pixels), stride);
  if (const std::optional<FilmedFrom>& filmed = player_.avatar().filmed)
    beyond_film_ +=
        IsBeyondFilm(*filmed, Face(), head_place_.center, math::ToVec3(camera.Center()));
}

}  // namespace cosplat::plugin

#include "apps/hosts/avatar_view.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <numbers>

namespace cosplat::hosts {

namespace {

float Radians(double degrees) { return float(degrees * std::numbers::pi / 180); }
double Degrees(float radians) { return double(radians) * 180 / std::numbers::pi; }

}  // namespace

std::optional<Background> ParseBackground(const std::string& text) {
  Background background;
  if (text == "avatar") return background;
  background.kind = Background::Kind::kTransparent;
  if (text == "transparent") return background;
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  background.kind = Background::Kind::kColor;
  for (size_t c = 0; c < 3; ++c) {
    const char* digits = text.data() + 1 + 2 * c;
    uint8_t byte = 0;
    const auto [end, error] = std::from_chars(digits, digits + 2, byte, 16);
    if (error != std::errc() || end != digits + 2) return std::nullopt;
    background.color[c] = float(byte) / 255;
  }
  return background;
}

AvatarView::AvatarView(const ViewSettings& settings) {
  Open(settings);
  if (!settings.drive.empty()) Drive(settings);
}

void AvatarView::Open(const ViewSettings& settings) {
  if (settings.avatar.empty())
    throw ViewError(COSPLAT_ERROR_ARGUMENT, "avatar: none is given; it is the path of a .glb");
  cosplat_open_options options{};
  options.struct_size = sizeof(options);
  options.flame_path = settings.flame.empty() ? nullptr : settings.flame.c_str();
  cosplat_avatar* opened = nullptr;
  const cosplat_status status = cosplat_open(settings.avatar.c_str(), &options, &opened);
  if (status != COSPLAT_OK) throw ViewError(status, cosplat_last_error(nullptr));
  avatar_.reset(opened);
  info_.struct_size = sizeof(info_);
  Check(cosplat_get_info(opened, &info_));
}

void AvatarView::Drive(const ViewSettings& settings) {
  cosplat_policy policy{};
  policy.struct_size = sizeof(policy);
  policy.loop = settings.loop;
  Check(cosplat_set_policy(avatar_.get(), &policy));
  Check(cosplat_set_drive(avatar_.get(), settings.drive.c_str()));
  driven_ = true;
}

void AvatarView::Advance(int64_t now_ns) {
  if (driven_) Check(cosplat_advance(avatar_.get(), now_ns));
}

cosplat_health AvatarView::Health() {
  cosplat_health health{};
  health.struct_size = sizeof(health);
  Check(cosplat_get_health(avatar_.get(), &health));
  return health;
}

std::string AvatarView::Status() {
  const cosplat_health health = Health();
  const bool beyond = health.beyond_film > beyond_film_;
  beyond_film_ = health.beyond_film;
  if (*health.drive_problem != 0 || !beyond) return health.drive_problem;
  char line[160];
  std::snprintf(line,
                sizeof(line),
                "A guess: the head was filmed from %.0f to %.0f degrees to its left, and from %.0f "
                "to %.0f upwards",
                Degrees(info_.filmed_yaw[0]),
                Degrees(info_.filmed_yaw[1]),
                Degrees(info_.filmed_pitch[0]),
                Degrees(info_.filmed_pitch[1]));
  return line;
}

void AvatarView::Check(cosplat_status status) const {
  if (status != COSPLAT_OK) throw ViewError(status, cosplat_last_error(avatar_.get()));
}

void AvatarView::LookFrom(const Orbit& orbit, uint32_t width, uint32_t height) {
  if (orbit == orbit_ && width == width_ && height == height_) return;
  cosplat_camera camera{};
  camera.struct_size = sizeof(camera);
  Check(cosplat_orbit_camera(avatar_.get(),
                             width,
                             height,
                             Radians(orbit.azimuth),
                             Radians(orbit.elevation),
                             float(orbit.zoom),
                             &camera));
  Check(cosplat_set_camera(avatar_.get(), &camera));
  orbit_ = orbit;
  width_ = width;
  height_ = height;
}

void AvatarView::Draw(const Orbit& orbit,
                      const Background& background,
                      uint32_t alpha,
                      cosplat_picture picture) {
  LookFrom(orbit, picture.width, picture.height);
  const bool transparent = background.kind == Background::Kind::kTransparent;
  picture.alpha = transparent ? alpha : uint32_t(COSPLAT_ALPHA_OPAQUE);
  const bool own = background.kind == Background::Kind::kAvatar;
  std::copy_n(own ? info_.background : background.color.data(), 3, picture.background);
  Check(cosplat_render(avatar_.get(), &picture));
}

}  // namespace cosplat::hosts

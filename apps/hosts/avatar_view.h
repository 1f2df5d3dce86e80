// Avatar view of a host plug-in: an avatar in front of an orbiting camera, using cosplat.h only.
//
// ViewSettings -> AvatarView -> Advance, Draw, once per frame -> the host's memory. Angles are in
// degrees, as users enter them.
#pragma once

#include <cosplat.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace cosplat::hosts {

// The message is one user-readable line: the library's own, or what is wrong with a setting.
class ViewError : public std::runtime_error {
 public:
  ViewError(cosplat_status status, const std::string& text)
      : std::runtime_error(text), status_(status) {}
  cosplat_status status() const { return status_; }

 private:
  cosplat_status status_;
};

struct ViewSettings {
  std::string avatar;  // a .glb
  std::string flame;   // the FLAME model it was trained with
  std::string drive;   // as in cosplat_set_drive; empty: the face is at rest
  bool loop = false;   // recordings restart at their end
  bool operator==(const ViewSettings&) const = default;
};

struct Orbit {
  double azimuth = 0;    // degrees, towards the subject's left
  double elevation = 0;  // degrees, upwards
  double zoom = 1;
  bool operator==(const Orbit&) const = default;
};
// Limits for user interfaces, in degrees; cosplat_orbit_camera allows an elevation of 1.5 radians.
inline constexpr double kMaxAzimuth = 360;
inline constexpr double kMaxElevation = 85;
inline constexpr double kSmallestZoom = 0.01;
inline constexpr double kMaxZoom = 100;

struct Background {
  enum class Kind { kAvatar, kTransparent, kColor };
  Kind kind = Kind::kAvatar;        // kAvatar: the one it was evaluated on
  std::array<float, 3> color = {};  // for kColor; sRGB, [0, 1]
  bool operator==(const Background&) const = default;
};
// "avatar", "transparent" or "#rrggbb"; nullopt for anything else.
std::optional<Background> ParseBackground(const std::string& text);

// Not thread-safe.
class AvatarView {
 public:
  // Throws ViewError, as do all other members.
  explicit AvatarView(const ViewSettings& settings);

  // Advances the face to `now_ns`, of any monotonic clock.
  void Advance(int64_t now_ns);
  // State of the drive at that time. Its strings are valid until the next call.
  cosplat_health Health();

  // One line for a user interface: the drive's problem, or that pictures since the last call show
  // the head from where it was not filmed; "" if all is well.
  std::string Status();

  // Draws into picture.pixels. `alpha` (COSPLAT_ALPHA_...) applies to a transparent background; the
  // alpha mode and background in `picture` are ignored.
  void Draw(const Orbit& orbit,
            const Background& background,
            uint32_t alpha,
            cosplat_picture picture);

 private:
  void Open(const ViewSettings& settings);
  void Drive(const ViewSettings& settings);
  void LookFrom(const Orbit& orbit, uint32_t width, uint32_t height);
  void Check(cosplat_status status) const;

  struct Closer {
    void operator()(cosplat_avatar* avatar) const { cosplat_close(avatar); }
  };
  std::unique_ptr<cosplat_avatar, Closer> avatar_;
  bool driven_ = false;
  cosplat_info info_{};
  uint64_t beyond_film_ = 0;  // pictures, at the last Status
  Orbit orbit_;               // of the current camera
  uint32_t width_ = 0, height_ = 0;
};

}  // namespace cosplat::hosts

// What a host plug-in shows: an avatar before a camera that orbits it, by cosplat.h alone.
//
// ViewSettings -> AvatarView -> Advance, Draw, once per frame -> the host's memory. Angles are in
// degrees, since people type them.
#pragma once

#include <cosplat.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

namespace cosplat::hosts {

// One line for people: the library's own, or what is wrong with a setting.
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
  std::string drive;   // as of cosplat_set_drive; empty: the face is at rest
  bool loop = false;   // recordings begin again at their end
  bool operator==(const ViewSettings&) const = default;
};

struct Orbit {
  double azimuth = 0;    // degrees, towards the subject's left
  double elevation = 0;  // degrees, upwards
  double zoom = 1;
  bool operator==(const Orbit&) const = default;
};
// Degrees to which hosts let people go: cosplat_orbit_camera allows 1.5 radians.
inline constexpr double kMaxAzimuth = 360;
inline constexpr double kMaxElevation = 85;
inline constexpr double kSmallestZoom = 0.01;
inline constexpr double kMaxZoom = 100;

struct Background {
  enum class Kind { kAvatar, kTransparent, kColor };
  Kind kind = Kind::kAvatar;        // the one that the avatar was trained on
  std::array<float, 3> color = {};  // of kColor; sRGB from 0 to 1
  bool operator==(const Background&) const = default;
};
// "avatar", "transparent" or "#rrggbb"; nothing if it is none of them.
std::optional<Background> ParseBackground(const std::string& text);

// For one thread at a time.
class AvatarView {
 public:
  // Throws ViewError, as everything here.
  explicit AvatarView(const ViewSettings& settings);

  // Brings the face to `now_ns`, of any clock that does not run backwards.
  void Advance(int64_t now_ns);
  // What the drive gave until then. Its texts stay until the next call.
  cosplat_health Health();

  // Into picture.pixels. `alpha`, COSPLAT_ALPHA_..., is for a background that is transparent; what
  // `picture` has there is not looked at.
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
  Orbit orbit_;  // of the camera that is set
  uint32_t width_ = 0, height_ = 0;
};

}  // namespace cosplat::hosts

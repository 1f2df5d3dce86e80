#include "apps/gstreamer/src_settings.h"

#include <array>
#include <optional>
#include <variant>

namespace cosplat::gstreamer {

namespace {

enum Property : guint {
  kAvatar = 1,
  kFlame,
  kDrive,
  kLoop,
  kBackground,
  kWidth,
  kHeight,
  kFps,
  kAzimuth,
  kElevation,
  kZoom,
  kIsLive
};

using Field = std::variant<std::string*, bool*, int*, double*, Fraction*>;
std::optional<Field> FieldOf(SrcSettings& s, guint property) {
  // In the order of Property.
  const std::array<Field, kIsLive> fields = {&s.view.avatar,
                                             &s.view.flame,
                                             &s.view.drive,
                                             &s.view.loop,
                                             &s.background,
                                             &s.width,
                                             &s.height,
                                             &s.fps,
                                             &s.orbit.azimuth,
                                             &s.orbit.elevation,
                                             &s.orbit.zoom,
                                             &s.is_live};
  if (property < kAvatar || property > kIsLive) return std::nullopt;
  return fields[property - kAvatar];
}

void Read(const GValue* value, std::string& field) {
  const char* text = g_value_get_string(value);
  field = text ? text : "";
}
void Read(const GValue* value, bool& field) { field = g_value_get_boolean(value); }
void Read(const GValue* value, int& field) { field = g_value_get_int(value); }
void Read(const GValue* value, double& field) { field = g_value_get_double(value); }
void Read(const GValue* value, Fraction& field) {
  field = {gst_value_get_fraction_numerator(value), gst_value_get_fraction_denominator(value)};
}

void Write(const std::string& field, GValue* value) { g_value_set_string(value, field.c_str()); }
void Write(bool field, GValue* value) { g_value_set_boolean(value, field); }
void Write(int field, GValue* value) { g_value_set_int(value, field); }
void Write(double field, GValue* value) { g_value_set_double(value, field); }
void Write(const Fraction& field, GValue* value) {
  gst_value_set_fraction(value, field.numerator, field.denominator);
}

constexpr int kFlags = G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS;
constexpr GParamFlags kFixed = GParamFlags(kFlags | GST_PARAM_MUTABLE_READY);
constexpr GParamFlags kPlaying = GParamFlags(kFlags | GST_PARAM_MUTABLE_PLAYING);
constexpr GParamFlags kControlled = GParamFlags(kPlaying | GST_PARAM_CONTROLLABLE);

struct Words {
  const char* name;
  const char* nick;
  const char* blurb;
};

void InstallText(
    GObjectClass* c, guint property, const Words& w, const char* value, GParamFlags flags) {
  g_object_class_install_property(
      c, property, g_param_spec_string(w.name, w.nick, w.blurb, value, flags));
}

void InstallSwitch(GObjectClass* c, guint property, const Words& w) {
  g_object_class_install_property(
      c, property, g_param_spec_boolean(w.name, w.nick, w.blurb, FALSE, kFixed));
}

void InstallSide(GObjectClass* c, guint property, const Words& w, int value) {
  g_object_class_install_property(
      c,
      property,
      g_param_spec_int(w.name, w.nick, w.blurb, 1, COSPLAT_LARGEST_SIDE, value, kFixed));
}

void InstallNumber(
    GObjectClass* c, guint property, const Words& w, double min, double max, double value) {
  g_object_class_install_property(
      c, property, g_param_spec_double(w.name, w.nick, w.blurb, min, max, value, kControlled));
}

void InstallFps(GObjectClass* c, const Words& w, const Fraction& value) {
  GParamSpec* spec = gst_param_spec_fraction(
      w.name, w.nick, w.blurb, 1, 1000, 1000, 1, value.numerator, value.denominator, kFixed);
  g_object_class_install_property(c, kFps, spec);
}

constexpr const char* kDriveBlurb =
    "What moves the face: webcam:, audio: (the microphone), a recording (.npz or folder), stdin:, "
    "udp://HOST:PORT, vmc://HOST:PORT, vts://PHONE, ifacialmocap://PHONE or livelink://HOST; empty "
    "leaves it at rest";
constexpr const char* kLoopBlurb =
    "Recordings begin again at their end; otherwise the stream ends there, unless it is live";
constexpr const char* kBackgroundBlurb =
    "avatar (that of its evaluation), transparent (straight alpha) or #rrggbb";
constexpr const char* kLiveBlurb =
    "Frames at the clock's pace, late ones left out, and not as fast as they are asked for";

}  // namespace

void InstallProperties(GObjectClass* c) {
  const SrcSettings d;
  InstallText(c, kAvatar, {"avatar", "Avatar", "Path of the avatar (.glb)"}, nullptr, kFixed);
  InstallText(c,
              kFlame,
              {"flame", "FLAME model", "Path of the model it was trained with (.pkl or .npz)"},
              nullptr,
              kFixed);
  InstallText(c, kDrive, {"drive", "Drive", kDriveBlurb}, nullptr, kFixed);
  InstallSwitch(c, kLoop, {"loop", "Loop", kLoopBlurb});
  InstallText(c,
              kBackground,
              {"background", "Background", kBackgroundBlurb},
              d.background.c_str(),
              kPlaying);
  InstallSide(c, kWidth, {"width", "Width", "Pixels, unless downstream has a wish"}, d.width);
  InstallSide(c, kHeight, {"height", "Height", "Pixels, unless downstream has a wish"}, d.height);
  InstallFps(c, {"fps", "Frames per second", "Unless downstream has a wish"}, d.fps);
  InstallNumber(c,
                kAzimuth,
                {"azimuth", "Azimuth", "Of the camera: degrees towards the subject's left"},
                -hosts::kMaxAzimuth,
                hosts::kMaxAzimuth,
                d.orbit.azimuth);
  InstallNumber(c,
                kElevation,
                {"elevation", "Elevation", "Of the camera: degrees upwards"},
                -hosts::kMaxElevation,
                hosts::kMaxElevation,
                d.orbit.elevation);
  InstallNumber(c,
                kZoom,
                {"zoom", "Zoom", "At 1 the head fills seven tenths of the shorter side"},
                hosts::kSmallestZoom,
                hosts::kMaxZoom,
                d.orbit.zoom);
  InstallSwitch(c, kIsLive, {"is-live", "Is live", kLiveBlurb});
}

bool SetSetting(SrcSettings& settings, guint property, const GValue* value) {
  const auto field = FieldOf(settings, property);
  if (field) std::visit([&](auto* f) { Read(value, *f); }, *field);
  return field.has_value();
}

bool GetSetting(SrcSettings& settings, guint property, GValue* value) {
  const auto field = FieldOf(settings, property);
  if (field) std::visit([&](auto* f) { Write(*f, value); }, *field);
  return field.has_value();
}

}  // namespace cosplat::gstreamer

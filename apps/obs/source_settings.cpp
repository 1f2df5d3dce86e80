// The source's settings: their user interface and how they are read.
#include <algorithm>

#include "apps/obs/avatar_source.h"

namespace cosplat::obs {

namespace {

constexpr double kMaxFps = 240;
constexpr int kMaxSide = 4096;

std::string TextOf(obs_data_t* settings, const char* name) {
  return obs_data_get_string(settings, name);
}

uint32_t SideOf(obs_data_t* settings, const char* name) {
  return uint32_t(std::clamp<long long>(obs_data_get_int(settings, name), 1, kMaxSide));
}

hosts::Background BackgroundOf(obs_data_t* settings) {
  hosts::Background background;
  const std::string kind = TextOf(settings, "background");
  if (kind == "avatar") return background;
  if (kind != "color") {
    background.kind = hosts::Background::Kind::kTransparent;
    return background;
  }
  background.kind = hosts::Background::Kind::kColor;
  const auto color = uint32_t(obs_data_get_int(settings, "background_color"));  // 0xAABBGGRR
  for (int c = 0; c < 3; ++c) background.color[c] = float((color >> (8 * c)) & 255) / 255;
  return background;
}

void AddNumber(obs_properties_t* p, const char* name, double min, double max, double step) {
  obs_properties_add_float_slider(p, name, obs_module_text(name), min, max, step);
}

void AddPath(obs_properties_t* p, const char* name, const char* filter) {
  obs_properties_add_path(p, name, obs_module_text(name), OBS_PATH_FILE, filter, nullptr);
}

bool ShowColor(obs_properties_t* p, obs_property_t*, obs_data_t* settings) {
  obs_property_t* color = obs_properties_get(p, "background_color");
  obs_property_set_visible(color, TextOf(settings, "background") == "color");
  return true;
}

void AddBackground(obs_properties_t* p) {
  obs_property_t* list = obs_properties_add_list(
      p, "background", obs_module_text("background"), OBS_COMBO_TYPE_LIST, OBS_COMBO_FORMAT_STRING);
  for (const char* kind : {"transparent", "avatar", "color"})
    obs_property_list_add_string(
        list, obs_module_text(("background_is_" + std::string(kind)).c_str()), kind);
  obs_property_set_modified_callback(list, ShowColor);
  obs_properties_add_color(p, "background_color", obs_module_text("background_color"));
}

}  // namespace

void SetDefaults(obs_data_t* settings) {
  obs_data_set_default_bool(settings, "loop", true);
  obs_data_set_default_string(settings, "background", "transparent");
  obs_data_set_default_int(settings, "background_color", 0xff00ff00);  // green-screen green
  obs_data_set_default_int(settings, "width", 512);
  obs_data_set_default_int(settings, "height", 512);
  obs_data_set_default_double(settings, "fps", 30);
  obs_data_set_default_double(settings, "zoom", 1);
}

obs_properties_t* MakeProperties() {
  obs_properties_t* p = obs_properties_create();
  AddPath(p, "avatar", "glTF (*.glb)");
  AddPath(p, "flame", "FLAME (*.pkl *.npz)");
  obs_property_t* drive =
      obs_properties_add_text(p, "drive", obs_module_text("drive"), OBS_TEXT_DEFAULT);
  obs_property_set_long_description(drive, obs_module_text("drive_help"));
  obs_properties_add_bool(p, "loop", obs_module_text("loop"));
  AddBackground(p);
  obs_properties_add_int(p, "width", obs_module_text("width"), 1, kMaxSide, 1);
  obs_properties_add_int(p, "height", obs_module_text("height"), 1, kMaxSide, 1);
  AddNumber(p, "fps", 1, kMaxFps, 1);
  AddNumber(p, "azimuth", -180, 180, 1);
  AddNumber(p, "elevation", -hosts::kMaxElevation, hosts::kMaxElevation, 1);
  AddNumber(p, "zoom", 0.1, 10, 0.05);
  return p;
}

PictureSettings ReadSettings(obs_data_t* settings) {
  PictureSettings out;
  out.view = {TextOf(settings, "avatar"),
              TextOf(settings, "flame"),
              TextOf(settings, "drive"),
              obs_data_get_bool(settings, "loop")};
  out.orbit = {obs_data_get_double(settings, "azimuth"),
               obs_data_get_double(settings, "elevation"),
               obs_data_get_double(settings, "zoom")};
  out.background = BackgroundOf(settings);
  out.width = SideOf(settings, "width");
  out.height = SideOf(settings, "height");
  out.fps = std::clamp(obs_data_get_double(settings, "fps"), 1.0, kMaxFps);
  return out;
}

}  // namespace cosplat::obs

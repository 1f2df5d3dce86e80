#include "apps/obs/avatar_source.h"

namespace cosplat::obs {

namespace {

AvatarSource& SourceOf(void* data) { return *static_cast<AvatarSource*>(data); }

const char* GetName(void*) { return obs_module_text("name"); }
void* Create(obs_data_t* settings, obs_source_t*) { return new AvatarSource(settings); }
void Destroy(void* data) { delete static_cast<AvatarSource*>(data); }
uint32_t GetWidth(void* data) { return SourceOf(data).width(); }
uint32_t GetHeight(void* data) { return SourceOf(data).height(); }
void Update(void* data, obs_data_t* settings) { SourceOf(data).Update(settings); }
void Show(void* data) { SourceOf(data).SetShown(true); }
void Hide(void* data) { SourceOf(data).SetShown(false); }
void Render(void* data, gs_effect_t*) { SourceOf(data).Render(); }
obs_properties_t* GetProperties(void* data) {
  return data ? SourceOf(data).Properties() : MakeProperties();
}

}  // namespace

AvatarSource::~AvatarSource() {
  obs_enter_graphics();
  gs_texture_destroy(texture_);
  obs_leave_graphics();
}

void AvatarSource::Update(obs_data_t* settings) {
  const PictureSettings read = ReadSettings(settings);
  width_ = read.width;
  height_ = read.height;
  pictures_.Set(read);
}

obs_properties_t* AvatarSource::Properties() const {
  obs_properties_t* properties = MakeProperties();
  const std::string status = pictures_.Status();
  if (!status.empty()) {
    obs_property_t* text =
        obs_properties_add_text(properties, "status", status.c_str(), OBS_TEXT_INFO);
    obs_property_text_set_info_type(text, OBS_TEXT_INFO_WARNING);
  }
  return properties;
}

void AvatarSource::Upload() {
  if (!pictures_.TakeImage(picture_)) return;
  const bool fits = texture_ && gs_texture_get_width(texture_) == picture_.width &&
                    gs_texture_get_height(texture_) == picture_.height;
  if (!fits) {
    gs_texture_destroy(texture_);
    texture_ = nullptr;
    if (picture_.width == 0) return;
    texture_ = gs_texture_create(picture_.width, picture_.height, GS_BGRA, 1, nullptr, GS_DYNAMIC);
  }
  gs_texture_set_image(texture_, picture_.pixels.data(), 4 * picture_.width, false);
}

void AvatarSource::Render() {
  Upload();
  if (!texture_) return;
  // No conversion to linear for the texture or the canvas: the bytes are blended as they are.
  const bool srgb = gs_framebuffer_srgb_enabled();
  gs_enable_framebuffer_srgb(false);
  gs_blend_state_push();
  gs_blend_function(GS_BLEND_ONE, GS_BLEND_INVSRCALPHA);
  gs_effect_t* effect = obs_get_base_effect(OBS_EFFECT_DEFAULT);
  gs_effect_set_texture(gs_effect_get_param_by_name(effect, "image"), texture_);
  while (gs_effect_loop(effect, "Draw")) gs_draw_sprite(texture_, 0, width_, height_);
  gs_blend_state_pop();
  gs_enable_framebuffer_srgb(srgb);
}

void RegisterAvatarSource() {
  obs_source_info info{};
  info.id = "cosplat_avatar";
  info.type = OBS_SOURCE_TYPE_INPUT;
  info.output_flags = OBS_SOURCE_VIDEO | OBS_SOURCE_CUSTOM_DRAW;
  info.icon_type = OBS_ICON_TYPE_CAMERA;
  info.get_name = GetName;
  info.create = Create;
  info.destroy = Destroy;
  info.get_width = GetWidth;
  info.get_height = GetHeight;
  info.get_defaults = SetDefaults;
  info.get_properties = GetProperties;
  info.update = Update;
  info.show = Show;
  info.hide = Hide;
  info.video_render = Render;
  obs_register_source(&info);
}

}  // namespace cosplat::obs

// Entry points of the OBS module cosplat.so.
OBS_DECLARE_MODULE()
OBS_MODULE_USE_DEFAULT_LOCALE("cosplat", "en-US")

MODULE_EXPORT const char* obs_module_description() {
  return "Head avatars of Gaussian splats as a source";
}

bool obs_module_load() {
  cosplat::obs::RegisterAvatarSource();
  return true;
}

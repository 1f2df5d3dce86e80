// The OBS source "CoSplat avatar".
//
// OBS's settings -> PictureThread -> a texture -> OBS's canvas.
//
// The source draws itself (video_render) and is not asynchronous, although its pictures come from a
// thread: OBS assumes straight alpha for frames of asynchronous sources, delays them to smooth
// their timing, and blends them in linear light. An avatar's picture has premultiplied alpha,
// should be shown immediately, and was blended in sRGB-encoded values.
#pragma once

#include <obs-module.h>

#include <atomic>

#include "apps/obs/picture_thread.h"

namespace cosplat::obs {

class AvatarSource {
 public:
  explicit AvatarSource(obs_data_t* settings) { Update(settings); }
  ~AvatarSource();
  AvatarSource(const AvatarSource&) = delete;
  AvatarSource& operator=(const AvatarSource&) = delete;

  void Update(obs_data_t* settings);
  void SetShown(bool shown) { pictures_.SetShown(shown); }
  // Called on OBS's graphics thread.
  void Render();
  obs_properties_t* Properties() const;

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }

 private:
  void Upload();

  PictureThread pictures_;
  Picture picture_;  // content of the texture
  gs_texture_t* texture_ = nullptr;
  std::atomic<uint32_t> width_ = 0, height_ = 0;  // px, from the settings
};

void SetDefaults(obs_data_t* settings);
obs_properties_t* MakeProperties();
PictureSettings ReadSettings(obs_data_t* settings);
void RegisterAvatarSource();

}  // namespace cosplat::obs

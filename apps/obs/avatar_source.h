// The OBS source "CoSplat avatar".
//
// OBS's settings -> PictureThread -> a texture -> OBS's canvas.
//
// It draws by itself (video_render) and is no asynchronous source, although its pictures come from
// a thread: OBS takes frames of asynchronous sources to have straight alpha, holds them back to
// smooth their times, and blends them in linear light. A picture of an avatar is premultiplied,
// should show as soon as it is there, and was blended as its bytes are.
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
  // On OBS's graphics thread.
  void Render();
  obs_properties_t* Properties() const;

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }

 private:
  void Upload();

  PictureThread pictures_;
  Picture picture_;  // the texture's
  gs_texture_t* texture_ = nullptr;
  std::atomic<uint32_t> width_ = 0, height_ = 0;  // px, as they are set
};

void SetDefaults(obs_data_t* settings);
obs_properties_t* MakeProperties();
PictureSettings ReadSettings(obs_data_t* settings);
void RegisterAvatarSource();

}  // namespace cosplat::obs

// cosplat.so, the OBS module.
#include "apps/obs/avatar_source.h"

OBS_DECLARE_MODULE()
OBS_MODULE_USE_DEFAULT_LOCALE("cosplat", "en-US")

MODULE_EXPORT const char* obs_module_description() {
  return "Head avatars of Gaussian splats as a source";
}

bool obs_module_load() {
  cosplat::obs::RegisterAvatarSource();
  return true;
}

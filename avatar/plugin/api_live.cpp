// cosplat.h: time, drives, the rule for bad frames.
#include "avatar/plugin/boundary.h"
#include "avatar/plugin/struct_size.h"

using namespace cosplat::plugin;  // NOLINT: this file is the outside of that namespace

cosplat_status cosplat_advance(cosplat_avatar* avatar, int64_t now_ns) {
  return WithAvatar(avatar, [&](Instance& instance) { instance.Advance(now_ns); });
}

cosplat_status cosplat_set_drive(cosplat_avatar* avatar, const char* drive) {
  return WithAvatar(avatar, [&](Instance& instance) { instance.SetDrive(drive); });
}

cosplat_status cosplat_set_policy(cosplat_avatar* avatar, const cosplat_policy* policy) {
  return WithAvatar(
      avatar, [&](Instance& instance) { instance.face().SetPolicy(ReadStruct(policy, "policy")); });
}

cosplat_status cosplat_get_health(cosplat_avatar* avatar, cosplat_health* health) {
  return WithAvatar(
      avatar, [&](Instance& instance) { WriteStruct(instance.face().Health(), health, "health"); });
}

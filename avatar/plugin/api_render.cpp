// cosplat.h: parameters, camera, rendering; time, drives, the policy for bad frames.
#include "avatar/plugin/boundary.h"
#include "avatar/plugin/struct_size.h"

using namespace cosplat::plugin;  // NOLINT: the C interface lies outside that namespace

cosplat_status cosplat_set_parameters(cosplat_avatar* avatar,
                                      const cosplat_parameters* parameters) {
  return WithAvatar(avatar, [&](Instance& instance) {
    const cosplat_parameters given = ReadStruct(parameters, "parameters");
    instance.ChangeParameters([&](LiveParameters& live) { live.Set(given); });
  });
}

cosplat_status cosplat_get_parameters(cosplat_avatar* avatar, cosplat_parameters* parameters) {
  return WithAvatar(avatar, [&](Instance& instance) {
    WriteStruct(instance.parameters().Get(), parameters, "parameters");
  });
}

cosplat_status cosplat_reset_parameters(cosplat_avatar* avatar) {
  return WithAvatar(avatar, [](Instance& instance) { instance.ResetParameters(); });
}

cosplat_status cosplat_set_expression(cosplat_avatar* avatar,
                                      uint32_t expression,
                                      float value,
                                      int64_t time_ns) {
  return WithAvatar(avatar, [&](Instance& instance) {
    instance.ChangeParameters(
        [&](LiveParameters& live) { live.SetExpression(expression, value, time_ns); });
  });
}

cosplat_status cosplat_set_joint(cosplat_avatar* avatar,
                                 uint32_t joint,
                                 const float axis_angle[3],
                                 int64_t time_ns) {
  return WithAvatar(avatar, [&](Instance& instance) {
    instance.ChangeParameters(
        [&](LiveParameters& live) { live.SetJoint(joint, axis_angle, time_ns); });
  });
}

cosplat_status cosplat_set_translation(cosplat_avatar* avatar,
                                       const float translation[3],
                                       int64_t time_ns) {
  return WithAvatar(avatar, [&](Instance& instance) {
    instance.ChangeParameters(
        [&](LiveParameters& live) { live.SetTranslation(translation, time_ns); });
  });
}

cosplat_status cosplat_set_camera(cosplat_avatar* avatar, const cosplat_camera* camera) {
  return WithAvatar(avatar, [&](Instance& instance) {
    instance.camera() = ToCamera(ReadStruct(camera, "camera"));
  });
}

cosplat_status cosplat_get_camera(cosplat_avatar* avatar, cosplat_camera* camera) {
  return WithAvatar(avatar, [&](Instance& instance) {
    if (!instance.camera()) throw CodedError(COSPLAT_ERROR_NOT_FOUND, "camera", "none is set");
    WriteStruct(FromCamera(*instance.camera()), camera, "camera");
  });
}

cosplat_status cosplat_orbit_camera(cosplat_avatar* avatar,
                                    uint32_t width,
                                    uint32_t height,
                                    float azimuth,
                                    float elevation,
                                    float zoom,
                                    cosplat_camera* camera) {
  return WithAvatar(avatar, [&](Instance& instance) {
    const Orbit orbit{azimuth, elevation, zoom};
    WriteStruct(
        FromCamera(OrbitCamera(instance.head_place(), width, height, orbit)), camera, "camera");
  });
}

cosplat_status cosplat_render(cosplat_avatar* avatar, const cosplat_picture* picture) {
  return WithAvatar(avatar,
                    [&](Instance& instance) { instance.Render(ReadStruct(picture, "picture")); });
}

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
  return WithAvatar(avatar,
                    [&](Instance& instance) { WriteStruct(instance.Health(), health, "health"); });
}

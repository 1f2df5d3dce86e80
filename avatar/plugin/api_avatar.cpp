// cosplat.h: versions, texts, opening and closing, properties of an avatar.
#include <array>
#include <string>
#include <string_view>

#include "avatar/plugin/boundary.h"
#include "avatar/plugin/struct_size.h"
#include "splat/base/text.h"

using namespace cosplat::plugin;  // NOLINT: the C interface lies outside that namespace

namespace {

#define COSPLAT_TEXT(x) #x
#define COSPLAT_DOTTED(major, minor, patch) \
  COSPLAT_TEXT(major) "." COSPLAT_TEXT(minor) "." COSPLAT_TEXT(patch)

constexpr std::array<std::string_view, COSPLAT_JOINT_COUNT> kJointNames = {
    "root", "neck", "jaw", "left_eye", "right_eye"};

// Indexed by status.
constexpr std::array<const char*, 13> kStatusTexts = {"ok",
                                                      "bad argument",
                                                      "not an open avatar",
                                                      "in use by another thread",
                                                      "not found",
                                                      "not a finite number",
                                                      "late",
                                                      "bad file",
                                                      "bad FLAME model",
                                                      "no such device",
                                                      "not enough memory",
                                                      "internal fault",
                                                      "bad drive"};

void RequirePointer(const void* pointer, const char* name) {
  if (!pointer) Refuse(name, "is NULL");
}

template <class Names>
void GiveName(const Names& names, uint32_t index, const char* what, const char** name) {
  RequirePointer(name, "name");
  if (index >= names.size())
    throw CodedError(
        COSPLAT_ERROR_NOT_FOUND, what, cosplat::Format("{} of {}", index, names.size()));
  *name = std::data(names[index]);
}

template <class Names>
void FindName(const Names& names, const char* name, const char* what, uint32_t* index) {
  RequirePointer(name, "name");
  RequirePointer(index, what);
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] != std::string_view(name)) continue;
    *index = uint32_t(i);
    return;
  }
  throw CodedError(COSPLAT_ERROR_NOT_FOUND, what, "there is no '" + std::string(name) + "'");
}

}  // namespace

uint32_t cosplat_version(void) { return COSPLAT_VERSION; }

const char* cosplat_version_text(void) {
  return COSPLAT_DOTTED(COSPLAT_VERSION_MAJOR, COSPLAT_VERSION_MINOR, COSPLAT_VERSION_PATCH);
}

const char* cosplat_status_text(cosplat_status status) {
  return status >= 0 && size_t(status) < kStatusTexts.size() ? kStatusTexts[size_t(status)]
                                                             : "unknown status";
}

const char* cosplat_last_error(cosplat_avatar* avatar) {
  if (!avatar) return LastErrorOfThread();
  const auto instance = Handles().Find(avatar);
  return instance ? instance->last_error().data() : "avatar: is not an open avatar";
}

cosplat_status cosplat_open(const char* avatar_path,
                            const cosplat_open_options* options,
                            cosplat_avatar** avatar) {
  return Guard(nullptr, COSPLAT_ERROR_FILE, [&] {
    RequirePointer(avatar, "avatar");
    *avatar = nullptr;
    RequirePointer(avatar_path, "avatar_path");
    const cosplat_open_options given = ReadStruct(options, "options");
    *avatar = Handles().Add(std::make_shared<Instance>(avatar_path, given));
  });
}

cosplat_status cosplat_close(cosplat_avatar* avatar) {
  return Guard(nullptr, COSPLAT_ERROR_INTERNAL, [&] {
    if (avatar && !Handles().Remove(avatar))
      throw CodedError(COSPLAT_ERROR_HANDLE, "avatar", "is not an open avatar");
  });
}

cosplat_status cosplat_get_info(cosplat_avatar* avatar, cosplat_info* info) {
  return WithAvatar(avatar,
                    [&](Instance& instance) { WriteStruct(instance.info(), info, "info"); });
}

cosplat_status cosplat_expression_name(cosplat_avatar* avatar,
                                       uint32_t expression,
                                       const char** name) {
  return WithAvatar(avatar, [&](Instance& instance) {
    GiveName(instance.expression_names(), expression, "expression", name);
  });
}

cosplat_status cosplat_joint_name(cosplat_avatar* avatar, uint32_t joint, const char** name) {
  return WithAvatar(avatar, [&](Instance&) { GiveName(kJointNames, joint, "joint", name); });
}

cosplat_status cosplat_find_expression(cosplat_avatar* avatar,
                                       const char* name,
                                       uint32_t* expression) {
  return WithAvatar(avatar, [&](Instance& instance) {
    FindName(instance.expression_names(), name, "expression", expression);
  });
}

cosplat_status cosplat_find_joint(cosplat_avatar* avatar, const char* name, uint32_t* joint) {
  return WithAvatar(avatar, [&](Instance&) { FindName(kJointNames, name, "joint", joint); });
}

#include "avatar/plugin/boundary.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace cosplat::plugin {
namespace {

thread_local std::array<char, 512> thread_error{};

void Keep(const char* text, std::array<char, 512>& kept) {
  const size_t length = std::min(std::strlen(text), kept.size() - 1);
  std::memcpy(kept.data(), text, length);
  kept[length] = 0;
}

}  // namespace

cosplat_status Fail(cosplat_status status, const char* text, Instance* instance) noexcept {
  Keep(text, thread_error);
  if (instance) Keep(text, instance->last_error());
  return status;
}

const char* LastErrorOfThread() noexcept { return thread_error.data(); }

std::shared_ptr<Instance> Enter(cosplat_avatar* avatar) {
  std::shared_ptr<Instance> instance = Handles().Find(avatar);
  if (!instance) throw CodedError(COSPLAT_ERROR_HANDLE, "avatar", "is not an open avatar");
  if (!instance->TryEnter())
    throw CodedError(COSPLAT_ERROR_BUSY, "avatar", "is in use by another thread");
  return instance;
}

}  // namespace cosplat::plugin

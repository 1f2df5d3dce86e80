// Which avatars are open. A handle is a number that is never used twice, not a pointer: one that is
// wrong, or was closed, is not found, and nothing is read through it.
#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>

#include "avatar/plugin/instance.h"

namespace cosplat::plugin {

// For any thread.
class HandleTable {
 public:
  cosplat_avatar* Add(std::shared_ptr<Instance> instance);
  // Null when there is none. Who finds it keeps it, even if another thread closes it meanwhile.
  std::shared_ptr<Instance> Find(cosplat_avatar* handle);
  std::shared_ptr<Instance> Remove(cosplat_avatar* handle);

 private:
  std::mutex mutex_;
  uintptr_t count_ = 0;  // opened so far
  std::unordered_map<uintptr_t, std::shared_ptr<Instance>> open_;
};

// The library's one table. It is never destroyed: a host's threads may still draw while it exits.
HandleTable& Handles();

}  // namespace cosplat::plugin

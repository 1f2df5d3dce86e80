// The table of open avatars. A handle is a number that is never reused, not a pointer: an invalid
// or closed one is not found and never dereferenced.
#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>

#include "avatar/plugin/instance.h"

namespace cosplat::plugin {

// Thread-safe.
class HandleTable {
 public:
  cosplat_avatar* Add(std::shared_ptr<Instance> instance);
  // Null when there is none. The caller shares ownership, so that the instance survives another
  // thread closing it.
  std::shared_ptr<Instance> Find(cosplat_avatar* handle);
  std::shared_ptr<Instance> Remove(cosplat_avatar* handle);

 private:
  std::mutex mutex_;
  uintptr_t count_ = 0;  // opened so far
  std::unordered_map<uintptr_t, std::shared_ptr<Instance>> open_;
};

// The library's only table. It is never destroyed: a host's threads may still render while the host
// exits.
HandleTable& Handles();

}  // namespace cosplat::plugin

#include "avatar/plugin/handle_table.h"

#include <utility>

namespace cosplat::plugin {
namespace {

// Multiplication by any odd number maps counts to handles one to one. This one, 2^64 divided by the
// golden ratio (Knuth, TAOCP 6.4), spreads them, so that small numbers and a host's addresses are
// not valid handles.
constexpr uintptr_t kSpread = uintptr_t(0x9E3779B97F4A7C15u);

uintptr_t KeyOf(cosplat_avatar* handle) { return reinterpret_cast<uintptr_t>(handle); }

}  // namespace

cosplat_avatar* HandleTable::Add(std::shared_ptr<Instance> instance) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const uintptr_t key = (count_ + 1) * kSpread;
  open_.emplace(key, std::move(instance));
  ++count_;
  return reinterpret_cast<cosplat_avatar*>(key);
}

std::shared_ptr<Instance> HandleTable::Find(cosplat_avatar* handle) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = open_.find(KeyOf(handle));
  return found == open_.end() ? nullptr : found->second;
}

std::shared_ptr<Instance> HandleTable::Remove(cosplat_avatar* handle) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = open_.find(KeyOf(handle));
  if (found == open_.end()) return nullptr;
  const std::shared_ptr<Instance> instance = std::move(found->second);
  open_.erase(found);
  return instance;
}

HandleTable& Handles() {
  static HandleTable& table = *new HandleTable;
  return table;
}

}  // namespace cosplat::plugin

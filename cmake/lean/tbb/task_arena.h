// See parallel_for.h: no thread of that pool takes up other work while it waits.
#pragma once

namespace tbb {

// Of one thread: within a loop of that pool, loops run in their own thread anyway.
class task_arena {
 public:
  explicit task_arena(int) {}
  template <class F>
  auto execute(const F& f) {
    return f();
  }
};

}  // namespace tbb

namespace tbb::this_task_arena {

template <class F>
auto isolate(const F& f) {
  return f();
}

}  // namespace tbb::this_task_arena

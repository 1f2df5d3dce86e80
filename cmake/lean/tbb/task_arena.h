// See parallel_for.h: no thread of that pool takes up other work while it waits.
#pragma once

namespace tbb::this_task_arena {

template <class F>
auto isolate(const F& f) {
  return f();
}

}  // namespace tbb::this_task_arena

// See parallel_for.h: the pool's size is fixed before its first loop.
#pragma once

#include "parallel_for.h"

namespace tbb {

class global_control {
 public:
  enum parameter { max_allowed_parallelism };
  global_control(parameter, size_t threads) { lean::Pool::UseThreads(unsigned(threads)); }
};

}  // namespace tbb

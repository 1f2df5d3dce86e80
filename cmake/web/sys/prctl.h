// Emscripten has no processes: splat/base/process.cpp compiles, and says that none can be started.
#pragma once

constexpr int PR_SET_PDEATHSIG = 1;
inline int prctl(int, int) { return -1; }

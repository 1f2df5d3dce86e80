// Tells the thread sanitizer what orders the memory of an emulated device, so that it finds races:
// between threads of a block that no barrier keeps apart, and between blocks. To it every thread is
// one of its fibers, switched without an order; what orders is the begin and the end of a grid,
// __syncthreads and __syncwarp, but no shuffle or vote. Does nothing in builds without
// COSPLAT_FIND_RACES, which only the target of tests/cuda has that is instrumented.
#pragma once

namespace cuda_on_host {

#if defined(COSPLAT_FIND_RACES)

constexpr bool kFindsRaces = true;

extern "C" {
void* __tsan_get_current_fiber();
void* __tsan_create_fiber(unsigned flags);
void __tsan_switch_to_fiber(void* fiber, unsigned flags);
void __tsan_acquire(void* at);
void __tsan_release(void* at);
void AnnotateIgnoreWritesBegin(const char* file, int line);
void AnnotateIgnoreWritesEnd(const char* file, int line);
}

inline void* NewRaceContext() { return __tsan_create_fiber(0); }
inline void* CurrentRaceContext() { return __tsan_get_current_fiber(); }
inline void SwitchRaceContext(void* to) { __tsan_switch_to_fiber(to, /*no order*/ 1); }
// All that the caller did is before what those do that `Follow` the same object later.
inline void Precede(const void* object) { __tsan_release(const_cast<void*>(object)); }
inline void Follow(const void* object) { __tsan_acquire(const_cast<void*>(object)); }
// While one exists, the emulation writes to data of its own that nothing orders: it is not
// instrumented, but may call functions that are (memset, templates of the standard library).
struct UnseenWrites {
  UnseenWrites() { AnnotateIgnoreWritesBegin(__FILE__, __LINE__); }
  ~UnseenWrites() { AnnotateIgnoreWritesEnd(__FILE__, __LINE__); }
};

#else

constexpr bool kFindsRaces = false;

inline void* NewRaceContext() { return nullptr; }
inline void* CurrentRaceContext() { return nullptr; }
inline void SwitchRaceContext(void*) {}
inline void Precede(const void*) {}
inline void Follow(const void*) {}
struct UnseenWrites {
  UnseenWrites() {}
};

#endif

}  // namespace cuda_on_host

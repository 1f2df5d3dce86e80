// Runs CUDA kernels on the host: what a device does, slowly and with every check that comes to
// mind.
//
// A block's threads are fibers (x86-64) of one thread of the host. They run until they meet: at a
// barrier of the block or a collective of the warp. Which runs next is drawn at random, as is the
// order of blocks, so that what depends on an order differs between seeds. Shared memory is filled
// with NaN before every block. A meeting that some thread cannot reach, or that threads reach at
// different places in the source, is a Fault.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <source_location>
#include <stdexcept>
#include <string>

namespace cuda_on_host {

// What would be undefined behaviour on a device.
class Fault : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Dim {
  unsigned x = 1, y = 1, z = 1;
  Dim(unsigned x = 1, unsigned y = 1, unsigned z = 1) : x(x), y(y), z(z) {}  // NOLINT: as dim3
};

constexpr unsigned kWarpSize = 32;
constexpr size_t kSharedBytes = 48 * 1024;  // static shared memory of a block

// The seed of all orders from here on.
void SetSchedule(uint64_t seed);

// Runs `thread` for every thread of the grid.
void RunGrid(const Dim& grid, const Dim& block, const std::function<void()>& thread);

// All 32 lanes meet; each gets all lanes' values, valid until it meets them again. Whether memory
// is ordered by it: a __syncwarp's is, a shuffle's is not.
enum class MemoryOrder { kNone, kOrdered };
const uint64_t* MeetWarp(unsigned mask,
                         uint64_t value,
                         MemoryOrder order,
                         const std::source_location& where);
// All threads of the block meet; each gets how many brought something other than 0.
int MeetBlock(int value, const std::source_location& where);
unsigned Lane();

// Memory of the running block, one piece for each `key`.
void* SharedMemoryOf(const void* key, size_t bytes);
// Of the piece whose size the launch of the running grid stated.
inline size_t launched_shared_bytes = 0;

}  // namespace cuda_on_host

// Of the thread that runs; CUDA's names.
inline cuda_on_host::Dim threadIdx, blockIdx, blockDim, gridDim;

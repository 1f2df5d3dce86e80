#include "tests/support/cuda_on_host/execution.h"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <new>
#include <numeric>
#include <vector>

#include "splat/base/rng.h"
#include "tests/support/cuda_on_host/races.h"

// Saves what a called function must keep and the stack pointer, and goes on where `to` was saved.
extern "C" void cosplat_switch_fiber(void** from, void* to);
asm(R"(
.text
.globl cosplat_switch_fiber
.type cosplat_switch_fiber, @function
cosplat_switch_fiber:
  pushq %rbp
  pushq %rbx
  pushq %r12
  pushq %r13
  pushq %r14
  pushq %r15
  movq %rsp, (%rdi)
  movq %rsi, %rsp
  popq %r15
  popq %r14
  popq %r13
  popq %r12
  popq %rbx
  popq %rbp
  ret
.size cosplat_switch_fiber, .-cosplat_switch_fiber
)");

namespace cuda_on_host {
namespace {

constexpr size_t kStackBytes = 64 * 1024;
constexpr unsigned kMaxThreads = 1024;
constexpr int kPoison = 0xff;     // four of them are a NaN
constexpr size_t kMaxShared = 8;  // variables of a block

using Place = std::source_location;
std::string ToString(const Place& p) {
  return std::string(p.file_name()) + ":" + std::to_string(p.line());
}
bool Same(const Place& a, const Place& b) {
  return a.line() == b.line() && std::strcmp(a.file_name(), b.file_name()) == 0;
}

// Threads that meet: of a warp or of the block.
struct Meeting {
  unsigned arrived = 0;
  Place where;
  std::array<uint64_t, kWarpSize> in{}, out{};  // of a warp's lanes
  int sum = 0, last_sum = 0;                    // of a block's threads
};

struct Fiber {
  void* stack_pointer = nullptr;
  const Meeting* waits_at = nullptr;
  bool done = false;
  void* race_context = nullptr;
};

// The block that runs.
struct Block {
  const std::function<void()>* thread = nullptr;
  unsigned count = 0, current = 0;
  std::array<Fiber, kMaxThreads> fibers;
  std::array<Dim, kMaxThreads> index;
  std::array<Meeting, kMaxThreads / kWarpSize> warps;
  Meeting barrier;
  std::vector<unsigned> ready;
  void* scheduler = nullptr;  // its stack pointer
  void* scheduler_race_context = nullptr;
  const char grid_begin = 0, grid_end = 0;  // what races are ordered by (races.h)
  std::exception_ptr problem;
  struct {
    const void* key;
    size_t at;
  } shared[kMaxShared];
  size_t shared_count = 0, shared_used = 0;
};
Block run;
cosplat::Rng order;

// The block's shared memory, and behind it its threads' stacks. Where races are looked for, what is
// used of it is mapped anew for each block, so that what the sanitizer knows of accesses to it
// (races.h) is of this block. It takes most of the time of small blocks.
char* Memory() {
  static char* const memory = [] {
    void* p = mmap(nullptr,
                   kSharedBytes + kMaxThreads * kStackBytes,
                   PROT_READ | PROT_WRITE,
                   MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE,
                   -1,
                   0);
    if (p == MAP_FAILED) throw std::bad_alloc();
    return static_cast<char*>(p);
  }();
  return memory;
}
char* StackOf(unsigned t) { return Memory() + kSharedBytes + t * kStackBytes; }

void RenewMemory() {
  if (kFindsRaces) {
    const void* p = mmap(Memory(),
                         kSharedBytes + run.count * kStackBytes,
                         PROT_READ | PROT_WRITE,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED,
                         -1,
                         0);
    if (p == MAP_FAILED) throw std::bad_alloc();
  }
  std::memset(Memory(), kPoison, kSharedBytes);
}

// Leaves the running thread, whose state goes to *from, for one that can run, or for the scheduler.
void SwitchToNext(void** from) {
  if (run.ready.empty() || run.problem) {
    SwitchRaceContext(run.scheduler_race_context);
    return cosplat_switch_fiber(from, run.scheduler);
  }
  const size_t k = order.Below(run.ready.size());
  std::swap(run.ready[k], run.ready.back());
  run.current = run.ready.back();
  run.ready.pop_back();
  threadIdx = run.index[run.current];
  SwitchRaceContext(run.fibers[run.current].race_context);
  cosplat_switch_fiber(from, run.fibers[run.current].stack_pointer);
}

[[noreturn]] void Thread() {
  Follow(&run.grid_begin);
  try {
    (*run.thread)();
  } catch (...) {
    run.problem = std::current_exception();
  }
  Precede(&run.grid_end);
  run.fibers[run.current].done = true;
  SwitchToNext(&run.fibers[run.current].stack_pointer);
  std::terminate();  // a thread that is done is not run again
}

// Of thread t: blocks that follow each other have different ones, or their threads of one number
// would be ordered.
void* RaceContextOf(unsigned t, bool odd_block) {
  static std::array<std::array<void*, kMaxThreads>, 2> contexts{};
  void*& context = contexts[odd_block][t];
  if (!context) context = NewRaceContext();
  return context;
}

void Start(unsigned t, bool odd_block) {
  void** top = reinterpret_cast<void**>(StackOf(t + 1));
  top[-2] = reinterpret_cast<void*>(&Thread);
  std::fill(top - 8, top - 2, nullptr);  // six registers
  run.fibers[t] = {top - 8, nullptr, false, RaceContextOf(t, odd_block)};
}

void Arrive(Meeting& meeting, const Place& where) {
  if (meeting.arrived++ == 0)
    meeting.where = where;
  else if (!Same(meeting.where, where))
    throw Fault("threads meet at " + ToString(meeting.where) + " and at " + ToString(where));
}

// Lets threads [begin, begin + count) go on.
void Release(Meeting& meeting, unsigned begin, unsigned count) {
  meeting.arrived = 0;
  for (unsigned t = begin; t < begin + count; ++t) {
    run.fibers[t].waits_at = nullptr;
    if (t != run.current) run.ready.push_back(t);
  }
}

void Wait(const Meeting& meeting) {
  Fiber& self = run.fibers[run.current];
  self.waits_at = &meeting;
  SwitchToNext(&self.stack_pointer);
}

void CheckAllDone() {
  unsigned done = 0;
  const Meeting* waited = nullptr;
  for (unsigned t = 0; t < run.count; ++t) {
    done += run.fibers[t].done;
    if (run.fibers[t].waits_at) waited = run.fibers[t].waits_at;
  }
  if (waited)
    throw Fault(std::to_string(waited->arrived) + " threads wait at " + ToString(waited->where) +
                " for others that do not come; " + std::to_string(done) + " of " +
                std::to_string(run.count) + " have ended");
}

void PrepareBlock(bool odd) {
  const UnseenWrites unseen;
  RenewMemory();
  run.shared_count = run.shared_used = 0;
  run.problem = nullptr;
  run.barrier = {};
  run.warps.fill({});
  run.ready.resize(run.count);
  std::iota(run.ready.begin(), run.ready.end(), 0u);
  for (unsigned t = 0; t < run.count; ++t) Start(t, odd);
}

void RunBlock(bool odd) {
  PrepareBlock(odd);
  Precede(&run.grid_begin);
  SwitchToNext(&run.scheduler);
  if (run.problem) std::rethrow_exception(run.problem);
  CheckAllDone();
}

}  // namespace

void SetSchedule(uint64_t seed) { order.state = seed; }

void RunGrid(const Dim& grid, const Dim& block, const std::function<void()>& thread) {
  const unsigned count = block.x * block.y * block.z;
  if (count == 0 || count > kMaxThreads || count % kWarpSize != 0)
    throw Fault("a block of " + std::to_string(count) + " threads: no warps, or too many");
  if (grid.x == 0 || grid.y == 0 || grid.z == 0) throw Fault("a grid without blocks");
  gridDim = grid;
  blockDim = block;
  run.count = count;
  run.thread = &thread;
  for (unsigned t = 0; t < count; ++t)
    run.index[t] = {t % block.x, t / block.x % block.y, t / block.x / block.y};
  std::vector<size_t> blocks(size_t(grid.x) * grid.y * grid.z);
  std::iota(blocks.begin(), blocks.end(), size_t(0));
  for (size_t i = blocks.size(); i > 1; --i) std::swap(blocks[i - 1], blocks[order.Below(i)]);
  run.scheduler_race_context = CurrentRaceContext();
  bool odd = false;
  for (const size_t b : blocks) {
    blockIdx = {unsigned(b % grid.x), unsigned(b / grid.x % grid.y), unsigned(b / grid.x / grid.y)};
    RunBlock(odd);
    odd = !odd;
  }
  Follow(&run.grid_end);
}

const uint64_t* MeetWarp(unsigned mask, uint64_t value, MemoryOrder order, const Place& where) {
  if (mask != ~0u) throw Fault("a collective of a part of a warp at " + ToString(where));
  const unsigned warp = run.current / kWarpSize, lane = run.current % kWarpSize;
  Meeting& meeting = run.warps[warp];
  Arrive(meeting, where);
  if (order == MemoryOrder::kOrdered) Precede(&meeting);
  meeting.in[lane] = value;
  if (meeting.arrived == kWarpSize) {
    meeting.out = meeting.in;
    Release(meeting, warp * kWarpSize, kWarpSize);
  } else {
    Wait(meeting);
  }
  if (order == MemoryOrder::kOrdered) Follow(&meeting);
  return meeting.out.data();
}

int MeetBlock(int value, const Place& where) {
  Meeting& meeting = run.barrier;
  Arrive(meeting, where);
  Precede(&meeting);
  meeting.sum += value != 0;
  if (meeting.arrived == run.count) {
    meeting.last_sum = meeting.sum;
    meeting.sum = 0;
    Release(meeting, 0, run.count);
  } else {
    Wait(meeting);
  }
  Follow(&meeting);
  return meeting.last_sum;
}

unsigned Lane() { return run.current % kWarpSize; }

void* SharedMemoryOf(const void* key, size_t bytes) {
  for (size_t i = 0; i < run.shared_count; ++i)
    if (run.shared[i].key == key) return Memory() + run.shared[i].at;
  const size_t at = run.shared_used;
  run.shared_used += (bytes + 63) / 64 * 64;
  if (run.shared_count == kMaxShared || run.shared_used > kSharedBytes)
    throw Fault("more shared memory than a block has");
  run.shared[run.shared_count++] = {key, at};
  return Memory() + at;
}

}  // namespace cuda_on_host

#include "tests/support/cuda_on_host/runtime.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "tests/support/cuda_on_host/execution.h"

namespace cuda_on_host {
namespace {

constexpr int kPoison = 0xff;
constexpr size_t kAlignment = 16;  // and whatever the size is a multiple of
constexpr std::align_val_t kPinnedAlignment{64};

struct Allocation {
  char* pages = nullptr;
  size_t page_bytes = 0;  // without the guard
  size_t bytes = 0;
};
std::map<void*, Allocation> on_device;
std::map<const void*, size_t> pinned;
std::deque<std::function<void()>> queue;
uint64_t enqueued = 0;
Waits waits;
std::exception_ptr problem;  // of work that was done where nobody could be told
size_t free_bytes = size_t(1) << 40;
int driver_problem = 0, driver_version = 13000;

// Of all of the above; what is done for the device enqueues and allocates, too.
std::recursive_mutex mutex;
using Lock = std::lock_guard<std::recursive_mutex>;

size_t PageBytes() { return size_t(sysconf(_SC_PAGESIZE)); }

void Protect(int access) {
  for (const auto& [p, a] : on_device)
    if (a.page_bytes != 0 && mprotect(a.pages, a.page_bytes, access) != 0)
      throw Fault("mprotect failed");
}

// Where memory is given back: in destructors, which must not throw.
void FinishQuietly() {
  try {
    Finish();
  } catch (...) {
    problem = std::current_exception();
  }
}

// While the device works.
struct DeviceWorks {
  DeviceWorks() { Protect(PROT_READ | PROT_WRITE); }
  ~DeviceWorks() { Protect(PROT_NONE); }
};

}  // namespace

void SetFreeMemory(size_t bytes) {
  const Lock lock(mutex);
  free_bytes = bytes;
}
size_t FreeMemory() {
  const Lock lock(mutex);
  return free_bytes;
}

void SetDriver(int problem, int version) {
  const Lock lock(mutex);
  driver_problem = problem;
  driver_version = version;
}
int DriverProblem() {
  const Lock lock(mutex);
  return driver_problem;
}
int DriverVersion() {
  const Lock lock(mutex);
  return driver_version;
}

void* AllocateOnDevice(size_t bytes) {
  const Lock lock(mutex);
  if (bytes > free_bytes) return nullptr;
  const size_t page = PageBytes(), used = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  Allocation a;
  a.bytes = bytes;
  a.page_bytes = (used + page - 1) / page * page;
  void* pages = mmap(
      nullptr, a.page_bytes + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED) return nullptr;
  a.pages = static_cast<char*>(pages);
  std::memset(a.pages, kPoison, a.page_bytes);
  mprotect(a.pages, a.page_bytes + page, PROT_NONE);
  free_bytes -= bytes;
  char* p = a.pages + a.page_bytes - used;
  on_device[p] = a;
  return p;
}

bool FreeOnDevice(void* p) {
  const Lock lock(mutex);
  FinishQuietly();
  const auto at = on_device.find(p);
  if (at == on_device.end()) return false;
  free_bytes += at->second.bytes;
  munmap(at->second.pages, at->second.page_bytes + PageBytes());
  on_device.erase(at);
  return true;
}

void* AllocatePinned(size_t bytes) {
  const Lock lock(mutex);
  void* p = ::operator new(bytes, kPinnedAlignment);
  std::memset(p, kPoison, bytes);
  pinned[p] = bytes;
  return p;
}

bool FreePinned(void* p) {
  const Lock lock(mutex);
  FinishQuietly();
  if (pinned.erase(p) == 0) return false;
  ::operator delete(p, kPinnedAlignment);
  return true;
}

bool IsPinned(const void* p) {
  const Lock lock(mutex);
  const auto after = pinned.upper_bound(p);
  if (after == pinned.begin()) return false;
  const auto at = std::prev(after);
  return static_cast<const char*>(p) < static_cast<const char*>(at->first) + at->second;
}

void Enqueue(std::function<void()> work) {
  const Lock lock(mutex);
  queue.push_back(std::move(work));
  ++enqueued;
}

uint64_t Enqueued() {
  const Lock lock(mutex);
  return enqueued;
}
void Finish() { FinishUntil(Enqueued()); }
bool HasFinished() {
  const Lock lock(mutex);
  return queue.empty();
}
Waits WaitsSoFar() {
  const Lock lock(mutex);
  return waits;
}

void FinishUntil(uint64_t moment) {
  const Lock lock(mutex);
  if (problem) std::rethrow_exception(std::exchange(problem, nullptr));
  const uint64_t done = enqueued - queue.size();
  if (moment <= done) return;
  const auto end = queue.begin() + std::ptrdiff_t(moment - done);
  std::vector<std::function<void()>> work(queue.begin(), end);
  queue.erase(queue.begin(), end);
  ++waits.all;
  waits.idle += queue.empty();
  const DeviceWorks open;
  try {
    for (const auto& f : work) f();
  } catch (...) {
    queue.clear();
    throw;
  }
}

void Copy(void* to, const void* from, size_t bytes, bool to_host, bool from_host) {
  const Lock lock(mutex);
  if (from_host && !IsPinned(from)) {
    waits.all += !queue.empty();
    waits.idle += !queue.empty();
    const char* first = static_cast<const char*>(from);
    const auto kept = std::make_shared<std::vector<char>>(first, first + bytes);
    Enqueue([=] { std::memcpy(to, kept->data(), bytes); });
  } else {
    Enqueue([=] { std::memmove(to, from, bytes); });
  }
  if (to_host && !IsPinned(to)) Finish();
}

}  // namespace cuda_on_host

// The memory and the streams of the device that cuda_runtime.h pretends to have.
//
// What a stream is given is done when the host waits for it, no earlier, so that a host that does
// not wait sees NaN. Memory of the device ends at a page that nothing may touch, holds NaN at first
// and is out of the host's reach but while the device works: a pointer on the wrong side is a crash
// here as it is there. (The reverse, a kernel that reads the host's memory, is not noticed.)
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace cuda_on_host {

// May be called from several threads: one of them works for the device at a time, and does what all
// have enqueued.

// Bytes that allocations may still take; more is refused as by a device that is full.
void SetFreeMemory(size_t bytes);
size_t FreeMemory();

// What asking for devices gives: an error, or 0 for one device; and the driver's version, as CUDA
// writes it (1000 major + 10 minor; 0: no driver).
void SetDriver(int problem, int version);
int DriverProblem();
int DriverVersion();

void* AllocateOnDevice(size_t bytes);  // null where it does not fit
bool FreeOnDevice(void* p);            // false where it is not the begin of an allocation
void* AllocatePinned(size_t bytes);
bool FreePinned(void* p);
bool IsPinned(const void* p);

// To be done in order.
void Enqueue(std::function<void()> work);
// How much there was, so far: a moment to wait for.
uint64_t Enqueued();
// Does all that was enqueued, or what was up to a moment. Throws what the work threw; what came
// after it is dropped.
void Finish();
void FinishUntil(uint64_t moment);
bool HasFinished();  // nothing is left to be done
// How often the host waited for work that was not done yet, and how often until none was left. What
// a driver may wait for counts: copying from the host's memory that is not pinned.
struct Waits {
  size_t all = 0, idle = 0;
};
Waits WaitsSoFar();
// Copies between the sides; of the host's memory that is not pinned as CUDA does, which reads it at
// once and writes it before it returns.
void Copy(void* to, const void* from, size_t bytes, bool to_host, bool from_host);

}  // namespace cuda_on_host

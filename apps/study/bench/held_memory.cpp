#include "apps/study/bench/held_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <fstream>
#include <utility>

#include "apps/study/bench/step_timer.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

constexpr int kSteps = 3;  // all buffers have their final size after the first
constexpr uint64_t kSeed = 1;

// Of this process, excluding free memory retained by the C library.
double ResidentBytes() {
  malloc_trim(0);
  constexpr const char* kFile = "/proc/self/statm";
  std::ifstream in(kFile);
  double pages = 0, resident = 0;
  if (!(in >> pages >> resident)) throw Error(kFile, "resident", "cannot be read");
  return resident * double(sysconf(_SC_PAGESIZE));
}

double ResidentGrowth(size_t count, int side) {
  SyntheticView view = MakeSyntheticView(count, side, side, kSeed);
  SceneSubject subject({view.frame}, 1);
  const double before = ResidentBytes();
  Trainer trainer(SteadySettings(view.start.degree), subject, view.start);
  for (int i = 0; i < kSteps; ++i) trainer.Step();
  return ResidentBytes() - before;
}

}  // namespace

std::vector<MemoryPart> MemoryOfSteps(SyntheticView view, int steps) {
  SceneSubject subject({std::move(view.frame)}, 1);
  Trainer trainer(SteadySettings(view.start.degree), subject, std::move(view.start));
  for (int i = 0; i < steps; ++i) trainer.Step();
  return trainer.Memory();
}

double ResidentBytesPerGaussian(size_t fewer, size_t more, int side) {
  ResidentGrowth(fewer, side);  // absorbs one-time allocations of threads and code
  return (ResidentGrowth(more, side) - ResidentGrowth(fewer, side)) / double(more - fewer);
}

}  // namespace cosplat

#include "apps/study/bench/machine.h"

#include <hwy/targets.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <fstream>

#include "apps/study/bench/measure.h"
#include "splat/device/buffer.h"

namespace cosplat {

std::string CpuName() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const size_t value = line.find_first_not_of(" \t", line.find(':') + 1);
    if (value != std::string::npos) return line.substr(value);
  }
  return "unknown";
}

std::vector<SimdTarget> SimdTargets() {
  std::vector<SimdTarget> targets;
  // Starting at the lowest bit, the best target.
  for (const int64_t id : hwy::SupportedAndGeneratedTargets())
    targets.push_back({id, hwy::TargetName(id)});
  return targets;
}

OnlySimdTarget::OnlySimdTarget(const SimdTarget& target) {
  hwy::SetSupportedTargetsForTest(target.id);
}
OnlySimdTarget::~OnlySimdTarget() { hwy::SetSupportedTargetsForTest(0); }

double StreamGbs(size_t bytes, bool all_cores, int batches) {
  // Floats per task: enough to make the task overhead negligible.
  constexpr size_t kTask = 1 << 18;
  const size_t tasks = std::max<size_t>(1, bytes / (3 * sizeof(float) * kTask));
  Buffer<float> a(tasks * kTask), b(a.size(), 1.0f), c(a.size(), 2.0f);
  const auto triad = [&](size_t task) {
    float* to = a.data() + task * kTask;
    const float *x = b.data() + task * kTask, *y = c.data() + task * kTask;
    for (size_t i = 0; i < kTask; ++i) to[i] = x[i] + 0.5f * y[i];
  };
  const double seconds = FastestSeconds(batches, 1, [&] {
    if (all_cores) {
      tbb::parallel_for(size_t(0), tasks, triad);
    } else {
      for (size_t task = 0; task < tasks; ++task) triad(task);
    }
  });
  return 3e-9 * sizeof(float) * double(a.size()) / seconds;
}

}  // namespace cosplat

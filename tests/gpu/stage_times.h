// Where a training step's time on a device goes, and what each stage makes of the memory.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/support/device_step.h"

namespace cosplat::test {

constexpr std::array<const char*, 7> kStageNames{
    "project", "sort", "blend", "loss", "blend_back", "project_back", "adam"};

struct Stage {
  double ms = 0;     // median
  double bytes = 0;  // the fewest that it must move
};

struct StepTimes {
  std::array<Stage, kStageNames.size()> stages;
  double step_ms =
      0;  // median of whole steps, gaps between launches included; no host waits in one
  size_t visible = 0, instances = 0;
};

// Of `steps` steps after as many that are not counted.
StepTimes TimeSteps(DeviceStep& step, int steps);

// What copying within the device moves, 1e9 bytes per second, read and written: its ceiling.
double CopyGbs(size_t bytes, int copies);

}  // namespace cosplat::test

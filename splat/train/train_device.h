// Where training is done: what `--device` and `--deterministic` choose (splat/render/device.h).
#pragma once

#include <string>

#include "splat/render/device.h"
#include "splat/train/step_engine.h"

namespace cosplat {

// For Trainer, of static scenes (avatar/train/train_device.h for avatars). `deterministic`: sums in
// a fixed order, so that the same run has the same bits, which on the CPU it always has.
StepEngineMaker StepEngineOn(Device device,
                             bool deterministic,
                             const InstanceForecast& forecast = InstanceForecast());

// For people: "CPU", or the GPU's name.
std::string NameOf(Device device);

}  // namespace cosplat

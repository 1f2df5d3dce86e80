// Where avatars are trained: splat/train/train_device.h for them.
#pragma once

#include "splat/render/device.h"
#include "splat/train/step_engine.h"

namespace cosplat {

// For Trainer, as StepEngineOn. On a device the engine throws Error for AvatarSystem::kReleased,
// whose rule is the CPU's alone.
StepEngineMaker AvatarEngineOn(Device device, bool deterministic);

}  // namespace cosplat

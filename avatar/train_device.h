// Where avatars are trained: splat/train_device.h for them.
#pragma once

#include "avatar/trainer.h"
#include "splat/device.h"
#include "splat/step_engine.h"

namespace cosplat {

// For Trainer, of `subject`, which must outlive it. `deterministic` as for StepEngineOn. On a
// device the engine throws Error for AvatarSystem::kReleased, whose rule is the CPU's alone.
StepEngineMaker AvatarEngineOn(Device device, bool deterministic, AvatarSubject& subject);

}  // namespace cosplat

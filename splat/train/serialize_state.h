// What a checkpoint holds of a training run, field by field (splat/base/state_file.h): Trainer's
// own part (Trainer::Serialize), the Subject's (SubjectState::Serialize) and the pruning rule's
// (Pruner::Serialize).
//
// All functions write the state or read it, as the archive does. Reading checks what the fields are
// to fit together, and throws Error that names the first that does not.
#pragma once

#include <string>

#include "splat/base/state_file.h"
#include "splat/train/ranks/shards.h"
#include "splat/train/state/training_state.h"

namespace cosplat {

// Arrays of `count` Gaussians with this layout: degree, basis and number of corrections are a run's
// settings, not its state.
void Serialize(StateArchive& archive, const std::string& name, size_t count, Gaussians& gaussians);
// In host memory. frames: of the subject; gaussians: of all ranks, given or read. All ranks that
// divide the state call it: the first writes what the others only pass on (DiscardState), each
// reads, and keeps its share.
void Serialize(StateArchive& archive,
               size_t frames,
               Shards& shards,
               uint64_t& gaussians,
               TrainingState& state);
// For so many frames, or none; in host memory.
void Serialize(StateArchive& archive, size_t frames, ExposureState& exposures);

}  // namespace cosplat

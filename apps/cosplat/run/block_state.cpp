#include "apps/cosplat/run/block_state.h"

#include "splat/train/blocks/block_schedule.h"
#include "splat/train/describe_state.h"

namespace cosplat {

void BlockState::Describe(StateArchive& a, size_t frames, bool has_exposures) {
  a.Value("round", round);
  a.Value("cost", cost);
  a.Require(round <= kBlockRounds, "round", "is beyond the run's end");
  if (round == 0) return;
  cosplat::Describe(a, counts.size(), blocks);
  for (auto& of_block : views) {
    a.ArrayUpTo("views", of_block, frames);
    for (const uint32_t view : of_block)
      a.Require(view < frames, "views", "names one that is not there");
  }
  a.Array("counts", counts, counts.size());
  if (has_exposures) cosplat::Describe(a, frames, exposures);
}

}  // namespace cosplat

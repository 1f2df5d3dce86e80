#include "apps/cosplat/run/block_state.h"

#include "splat/train/describe_state.h"

namespace cosplat {

void BlockState::Describe(StateArchive& a, size_t frames, bool has_exposures) {
  a.Value("turn", turn);
  a.Value("cost", cost);
  if (turn == 0) return;
  cosplat::Describe(a, counts.size(), blocks);
  for (auto& of_block : views) {
    a.ArrayUpTo("views", of_block, frames);
    for (const uint32_t view : of_block)
      a.Require(view < frames, "views", "names one that is not there");
  }
  if (a.reads()) schedule = BlockSchedule(views);
  a.Require(turn <= schedule.last_turn(), "turn", "is beyond the run's end");
  a.Array("counts", counts, counts.size());
  if (has_exposures) cosplat::Describe(a, frames, exposures);
}

}  // namespace cosplat

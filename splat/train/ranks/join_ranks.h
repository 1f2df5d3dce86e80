// Which other processes train with this one.
#pragma once

#include <memory>

#include "splat/train/ranks/ranks.h"

namespace cosplat {

// The ranks that mpirun started this process among, or OneRank() where it did not. Once per
// process. Throws Error if there are several and the program was built without MPI.
std::shared_ptr<Ranks> JoinRanks();
// The same where it did, with MPI (Open MPI). Throws Error if that cannot be used.
std::shared_ptr<Ranks> JoinMpi();

}  // namespace cosplat

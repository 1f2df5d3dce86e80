// Ranks as processes that mpirun has started (Open MPI).
#pragma once

#include <memory>

#include "splat/train/ranks/ranks.h"

namespace cosplat {

// Joins the others; once per process. Throws Error if MPI cannot be used.
std::shared_ptr<Ranks> JoinMpi();

}  // namespace cosplat

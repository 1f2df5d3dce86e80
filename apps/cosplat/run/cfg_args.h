// Folders that 3DGS's own code wrote: cfg_args in place of run.json.
#pragma once

#include <string>

#include "splat/base/json.h"

namespace cosplat {

// What run.json would say: source, split, degree, background, and the highest iteration saved.
// Throws Error naming the field if cfg_args is not 3DGS's line ("Namespace(eval=True, ...)").
Json RunOfCfgArgs(const std::string& folder);

}  // namespace cosplat

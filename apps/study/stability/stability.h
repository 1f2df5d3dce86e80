// The stability suite of the splats' side: each way in which splatting is known to fail, the naive
// form measured beside ours. docs/stability.md explains the cases.
#pragma once

#include <vector>

#include "apps/study/stability/stability_case.h"

namespace cosplat {

// All cases, in the order in which they are shown. Some seconds; the same bits in every run.
std::vector<StabilityCase> SplatStability();

}  // namespace cosplat

// `cosplat study --stability`: where splatting is known to fail, the naive form beside ours.
#pragma once

#include <string>

namespace cosplat {

// Runs every case of the stability suite (apps/study/stability/stability.h,
// apps/study/avatar_stability/stability.h), times the ways to evaluate colour, and writes
// <folder>/basis_forms.svg, <folder>/stability.html, one self-contained page, and last
// <folder>/stability.json. Throws Error when the folder cannot be written to.
void WriteStabilityPage(const std::string& folder, bool quiet);

}  // namespace cosplat

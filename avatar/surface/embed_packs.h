// The loops of avatar/surface/binding.h over Gaussians: avatar/surface/kernels/embed.h on SIMD
// packs, compiled per instruction set and run over oneTBB. None of the formulas' headers: those are
// included once per instruction set.
#pragma once

#include "avatar/surface/kernels/arrays.h"

namespace cosplat {

void LaunchEmbed(const EmbedJob& job, const PosedArrays<float>& out);

// d_posed.frame may be null: zero.
void LaunchEmbedVjp(const EmbedJob& job,
                    const PosedArrays<const float>& d_posed,
                    const EmbedAdjoints& out);

}  // namespace cosplat

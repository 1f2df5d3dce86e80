// Bind and BindBackward by SplattingAvatar's rule as its code was released, faults included, for
// the preset that reproduces it and for playing what that trained.
//
// called by avatar/surface/binding.cpp where Embedding::released is set. The formula is
// avatar/math/released_embed.h. One Gaussian at a time: nobody waits for it. Bits do not depend on
// the number of threads.
#pragma once

#include "avatar/surface/binding.h"

namespace cosplat {

// The arrays and triangles have been checked, `out` has its size.
void BindReleased(const Gaussians& gaussians,
                  const Embedding& embedding,
                  const Surface& surface,
                  PosedGaussians& out);

// Writes all of kPosition (du and dv: zero), kRotation and kScaleLog of d_gaussians, which have
// their sizes.
void BindReleasedBackward(const Gaussians& gaussians,
                          const Embedding& embedding,
                          const Surface& surface,
                          const PosedGaussians& d_posed,
                          Gaussians& d_gaussians);

}  // namespace cosplat

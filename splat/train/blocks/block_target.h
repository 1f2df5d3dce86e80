// What a block of a scene is trained towards in a view, where the other blocks are in the image as
// they were before (splat/train/blocks/layers.h): not the photograph itself, since each of several
// blocks would then make up for the same error, and all of them together for more than that
// (measured: docs/tried.md).
#pragma once

#include "splat/base/image.h"
#include "splat/train/blocks/layers.h"
#include "splat/train/loss/photograph.h"

namespace cosplat {

// What the layers of all blocks show together and, of what the whole scene lacks of the photograph,
// the share of the pixel that is not covered by the others: a block makes up for what it shows, and
// for what nothing shows. Shares of a pixel add up to 1 where the blocks together are opaque, to
// more where they are not: what nothing shows any of them may fill.
//
// The whole scene is not quite what the layers show: it sorts Gaussians by their centres across all
// blocks, layers sort blocks first, which differs for Gaussians that overlap across a plane. A
// block is trained among layers, but what counts is what the finished scene shows; the difference
// hardly changes in a round, and so is left as it is (measured: docs/tried.md).
//
// photograph: of any number of channels (1, 3, or 4 with straight alpha). own: the block's layer as
// it was when `others` were made. whole: all blocks at that time, as the finished scene draws them.
// These may be empty: nothing. exposure: of the view, from the scene's colours to the photograph's.
// Returns RGBA of the photograph's size, alpha straight; what is covered by neither keeps the
// background.
Image8 TargetOfBlock(const Image8& photograph,
                     const FrameLayers& others,
                     const Image8& own,
                     const Image8& whole,
                     const Exposure& exposure);

}  // namespace cosplat

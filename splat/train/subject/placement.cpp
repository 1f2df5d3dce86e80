#include "splat/train/subject/placement.h"

#include "splat/device/for_each.h"
#include "splat/train/subject/kernels/add_offsets.h"

namespace cosplat {

void Placement::Move(View<const float> offsets,
                     size_t first,
                     Gaussians& gaussians,
                     Stream& stream) {
  ForEach(offsets.count, stream, AddOffsets{offsets, first, gaussians.values[kPosition].view()});
}

}  // namespace cosplat

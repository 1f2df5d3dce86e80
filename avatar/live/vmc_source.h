// Blendshapes of a face tracker by the Virtual Motion Capture protocol, live: docs/live-input.md.
//
// PacketInput -> ParseOsc -> VmcSource (by OpenLiveSource), with a BlendshapeMatrix -> LiveFrame.
#pragma once

#include <memory>

#include "avatar/live/blendshape_matrix.h"
#include "avatar/live/packet_input.h"
#include "avatar/live/source.h"

namespace cosplat {

std::unique_ptr<LiveSource> OpenVmcSource(std::unique_ptr<PacketInput> input,
                                          BlendshapeMatrix matrix,
                                          const LiveSourceOptions& options);

}  // namespace cosplat

// FLAME parameters as lines of JSON, live: docs/live-input.md.
//
// PacketInput -> ParseJsonFrame -> JsonSource (by OpenLiveSource) -> LiveFrame.
#pragma once

#include <memory>

#include "avatar/live/packet_input.h"
#include "avatar/live/source.h"

namespace cosplat {

std::unique_ptr<LiveSource> OpenJsonSource(std::unique_ptr<PacketInput> input,
                                           const LiveSourceOptions& options);

}  // namespace cosplat

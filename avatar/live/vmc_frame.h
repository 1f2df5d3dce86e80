// Blendshape scores as a packet of the Virtual Motion Capture protocol (docs/live-input.md), which
// VmcSource reads.
#pragma once

#include <string>

#include "avatar/model/blendshape_map.h"

namespace cosplat {

// An OSC bundle: a /VMC/Ext/Blend/Val per score, then /VMC/Ext/Blend/Apply.
std::string WriteVmcFrame(const BlendshapeScores& scores);

}  // namespace cosplat

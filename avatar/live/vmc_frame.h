// Blendshape scores and the head as a packet of the Virtual Motion Capture protocol
// (docs/live-input.md), which VmcSource reads.
#pragma once

#include <string>

#include "avatar/math/turn.h"
#include "avatar/model/blendshape_map.h"

namespace cosplat {

// An OSC bundle: the bones Neck and Head, a /VMC/Ext/Blend/Val per score, then
// /VMC/Ext/Blend/Apply. root, neck: the turns of FLAME's joints that these bones are, from rest, in
// its axes.
std::string WriteVmcFrame(const BlendshapeScores& scores,
                          const math::AxisAngle& root = {},
                          const math::AxisAngle& neck = {});

}  // namespace cosplat

// assets/voice/voice_net.bin, in the program.
#pragma once

#include <cstddef>

namespace cosplat {

extern const unsigned char kVoiceNet[];
extern const size_t kVoiceNetSize;

}  // namespace cosplat

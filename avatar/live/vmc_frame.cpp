#include "avatar/live/vmc_frame.h"

#include <bit>
#include <cstdint>

namespace cosplat {
namespace {

// OSC 1.0: text ends with one to four zeros, so that its length is a multiple of four.
std::string OscString(const std::string& text) {
  return text + std::string(4 - text.size() % 4, '\0');
}

std::string OscWord(uint32_t word) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += char(word >> shift & 0xff);
  return bytes;
}

void AppendMessage(const std::string& message, std::string& bundle) {
  bundle += OscWord(uint32_t(message.size())) + message;
}

}  // namespace

std::string WriteVmcFrame(const BlendshapeScores& scores) {
  std::string bundle = OscString("#bundle") + OscWord(0) + OscWord(1);  // "immediately"
  for (const auto& [name, score] : scores)
    AppendMessage(OscString("/VMC/Ext/Blend/Val") + OscString(",sf") + OscString(name) +
                      OscWord(std::bit_cast<uint32_t>(score)),
                  bundle);
  AppendMessage(OscString("/VMC/Ext/Blend/Apply") + OscString(","), bundle);
  return bundle;
}

}  // namespace cosplat

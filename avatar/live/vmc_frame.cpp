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

std::string OscFloat(float number) { return OscWord(std::bit_cast<uint32_t>(number)); }

// In Unity's axes, which are FLAME's mirrored: left-handed, with x to the subject's right. At the
// place that it has in the receiver's model.
void AppendBone(const std::string& name, const math::AxisAngle& turn, std::string& bundle) {
  const math::Quat<float> q = math::QuatOfAxisAngle(turn);
  std::string message = OscString("/VMC/Ext/Bone/Pos") + OscString(",sfffffff") + OscString(name);
  for (const float number : {0.0f, 0.0f, 0.0f, q.x, -q.y, -q.z, q.w}) message += OscFloat(number);
  AppendMessage(message, bundle);
}

}  // namespace

std::string WriteVmcFrame(const BlendshapeScores& scores,
                          const math::AxisAngle& root,
                          const math::AxisAngle& neck) {
  std::string bundle = OscString("#bundle") + OscWord(0) + OscWord(1);  // "immediately"
  AppendBone("Neck", root, bundle);
  AppendBone("Head", neck, bundle);
  for (const auto& [name, score] : scores)
    AppendMessage(
        OscString("/VMC/Ext/Blend/Val") + OscString(",sf") + OscString(name) + OscFloat(score),
        bundle);
  AppendMessage(OscString("/VMC/Ext/Blend/Apply") + OscString(","), bundle);
  return bundle;
}

}  // namespace cosplat

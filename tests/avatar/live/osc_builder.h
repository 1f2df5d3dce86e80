// OSC packets for tests.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "avatar/live/source.h"

namespace cosplat::test {

// Of a VMC source, whose description also names its map.
inline std::string AddressOf(const LiveSource& source) {
  const std::string description = source.Description();
  return description.substr(0, description.find(','));
}

inline std::string OscWord(uint32_t word) {
  return {char(word >> 24), char(word >> 16), char(word >> 8), char(word)};
}

inline std::string OscText(std::string text) {
  text.push_back('\0');
  while (text.size() % 4 != 0) text.push_back('\0');
  return text;
}

inline std::string OscFloat(float number) { return OscWord(std::bit_cast<uint32_t>(number)); }

inline std::string OscBundle(const std::vector<std::string>& elements) {
  std::string bundle = OscText("#bundle") + std::string(8, '\0');
  for (const std::string& element : elements) bundle += OscWord(uint32_t(element.size())) + element;
  return bundle;
}

inline std::string VmcValue(const std::string& name, float value) {
  return OscText("/VMC/Ext/Blend/Val") + OscText(",sf") + OscText(name) + OscFloat(value);
}

inline std::string VmcApply() { return OscText("/VMC/Ext/Blend/Apply") + OscText(","); }

// x, y, z, w by Unity's axes.
inline std::string VmcBone(const std::string& name, const std::vector<float>& rotation) {
  std::string packet = OscText("/VMC/Ext/Bone/Pos") + OscText(",sfffffff") + OscText(name) +
                       OscFloat(0) + OscFloat(0) + OscFloat(0);
  for (const float number : rotation) packet += OscFloat(number);
  return packet;
}

}  // namespace cosplat::test

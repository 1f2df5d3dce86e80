// Packets as apps on phones send them.
#pragma once

#include <array>
#include <bit>
#include <string>
#include <vector>

#include "splat/base/text.h"
#include "tests/avatar/live/osc_builder.h"

namespace cosplat::test {

// scores: R"({"k":"JawOpen","v":0.5},...)". Degrees: x yaw, y pitch, z roll.
inline std::string VtsPacket(const std::string& scores, const std::array<float, 3>& turn = {}) {
  const auto vector = [](float x, float y, float z) {
    return "{\"x\":" + std::to_string(x) + ",\"y\":" + std::to_string(y) +
           ",\"z\":" + std::to_string(z) + "}";
  };
  return "{\"Timestamp\":1700000000000,\"Hotkey\":-1,\"FaceFound\":true,\"Rotation\":" +
         vector(turn[0], turn[1], turn[2]) + ",\"Position\":" + vector(0, 1, 9) +
         ",\"EyeLeft\":" + vector(1, 2, 0) + ",\"EyeRight\":" + vector(1, 2, 0) +
         ",\"BlendShapes\":[" + scores + "]}";
}

inline const char* const kVtsNoFace = R"({"Timestamp":1,"FaceFound":false,"BlendShapes":[]})";

// scores: "jawOpen-50|"; head: "rx,ry,rz,x,y,z".
inline std::string IFacialMocapPacket(const std::string& scores, const std::string& head) {
  return scores + "=head#" + head + "|rightEye#1,2,3|leftEye#1,2,3|";
}

// numbers: Unreal's 61. Without any where `face` is false.
inline std::string LiveLinkPacket(const std::array<float, 61>& numbers, bool face = true) {
  std::string packet(1, '\6');
  for (const std::string& name : {std::string("0123456789ABCDEF"), std::string("phone")})
    packet.append(OscWord(uint32_t(name.size()))).append(name);
  packet.append(OscWord(3723)).append(OscFloat(0.5f)).append(OscWord(60)).append(OscWord(1));
  if (!face) return packet;
  packet += char(61);
  for (const float number : numbers) packet += OscFloat(number);
  return packet;
}

// What mutations begin with.
inline std::vector<std::string> VtsSeeds() {
  return {VtsPacket(R"({"k":"JawOpen","v":0.5},{"k":"EyeBlinkLeft","v":1})", {10, -5, 2}),
          VtsPacket(R"({"k":"other","v":-3})"),
          kVtsNoFace};
}
inline std::vector<std::string> IFacialMocapSeeds() {
  return {IFacialMocapPacket("jawOpen-50|eyeBlink_L--5|other-12|", "10.5,-3,0.25,0.1,0.2,0.4"),
          IFacialMocapPacket("jawOpen&50|mouthSmile_R & 20|", "0,0,0,0,0,0")};
}
inline std::vector<std::string> LiveLinkSeeds() {
  std::array<float, 61> numbers{};
  for (size_t i = 0; i < numbers.size(); ++i) numbers[i] = 0.015f * float(i);
  return {LiveLinkPacket(numbers), LiveLinkPacket({}), LiveLinkPacket({}, false)};
}

// A recording of Live Link Face.
inline std::string LiveLinkTable() {
  const std::string names = "JawOpen,JawRight,HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw";
  return "Timecode,BlendShapeCount," + names +
         "\n10:00:00:58.000,61,0.5,0,0.1,0,0,0\n10:00:00:59.250,0\n"
         "10:00:01:00.500,61,0.25,1,0,-0.1,0.2,0\n10:00:02:00.000,61,0,0,0,0,0,0\n";
}

}  // namespace cosplat::test

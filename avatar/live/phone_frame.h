// What an app on a phone says of a face in one packet.
//
// UdpInput -> ParseVtsFrame, ParseIFacialMocapFrame, ParseLiveLinkFrame -> PhoneSource.
// Sources: github.com/DenchiSoft/VTubeStudioBlendshapeUDPReceiverTest and
// ifacialmocap.com/for-developer describe two of them; Live Link Face's is Unreal's. None says
// which way angles grow: the signs here are those with which receivers of each are written.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "avatar/math/turn.h"
#include "avatar/model/blendshape_map.h"

namespace cosplat {

// Radians: down, to the subject's left, to the right shoulder; about FLAME's x, y and z.
using HeadAngles = std::array<float, 3>;
// First to the side, then up or down, then to a shoulder, each in the axes turned so far.
math::AxisAngle TurnOf(const HeadAngles& angles);

struct PhoneFrame {
  bool has_face = true;     // false: the app sees none, and nothing else is set
  BlendshapeScores scores;  // by the app's names, at most kMaxScore in magnitude
  HeadAngles head{};
  std::vector<std::string> dropped;  // names of what was sent as a score and is none
};

// They throw Error(source, field, ...) when the packet is not one frame, or its head's angles are
// not finite or beyond a full turn. A bad score costs only itself.
using PhoneParser = PhoneFrame (*)(const std::string& source, const std::string& packet);

// VTube Studio's iOS app, MeowFace: JSON, angles in degrees.
PhoneFrame ParseVtsFrame(const std::string& source, const std::string& packet);
// iFacialMocap: "name-12|name&12|...|=head#1,2,3,x,y,z|rightEye#...|", scores in percent, degrees.
PhoneFrame ParseIFacialMocapFrame(const std::string& source, const std::string& packet);
// Live Link Face: binary, version 6, 61 numbers, radians.
PhoneFrame ParseLiveLinkFrame(const std::string& source, const std::string& packet);

// For the parsers.
void AddScore(std::string_view name, double value, PhoneFrame& frame);
// `angle` in radians; throws Error(source, field, ...) if it is no angle. `unit`: radians in one of
// what is sent.
float AngleOf(const std::string& source, const char* field, double angle, double unit);
constexpr double kDegree = 0.017453292519943295;  // radians

}  // namespace cosplat

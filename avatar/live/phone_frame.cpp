#include "avatar/live/phone_frame.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "avatar/live/byte_reader.h"
#include "avatar/live/unused_input.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Of a packet: several times what apps send; more would cost a host's time.
constexpr long kMaxVtsObjects = 256;
constexpr size_t kMaxTextScores = 256;
constexpr double kMaxDegrees = 360;

// Live Link Face's packets: this version has 61 numbers, of which the last nine are angles.
constexpr int kLiveLinkVersion = 6, kLiveLinkNumbers = 61;

double VtsNumber(const JsonField& field) {
  return field.raw().is_number() ? field.raw().get<double>() : std::nan("");
}

std::string_view Trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t\r\n");
  return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin);
}

// NaN if it is no number.
double NumberIn(std::string_view text) {
  return NumberOf<double>(Trimmed(text)).value_or(std::nan(""));
}

// The text up to the separator, which is taken off `rest`; all of it if there is none.
std::string_view TakeUntil(char separator, std::string_view& rest) {
  const size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view part = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return part;
}

// "rx,ry,rz,x,y,z": right-handed axes with y up and z out of the face, as FLAME's.
HeadAngles IFacialMocapHead(const std::string& source, std::string_view numbers) {
  HeadAngles head;
  for (float& angle : head)
    angle = AngleOf(source, "head", NumberIn(TakeUntil(',', numbers)), kDegree);
  return head;
}

// "name-12", "name--12" or "name&12".
void ReadIFacialMocapScore(std::string_view text, PhoneFrame& frame) {
  size_t mark = text.find('&');
  if (mark == text.npos) mark = std::min(text.find('-'), text.size());
  const std::string_view name = Trimmed(text.substr(0, mark));
  AddScore(name, NumberIn(text.substr(std::min(mark + 1, text.size()))) / 100, frame);
}

// ARKit's 52 in the order of Unreal's list, which has these two pairs the other way round than
// kArkitNames and than Live Link Face's own recordings.
std::string_view LiveLinkName(size_t i) {
  constexpr size_t kJawRight = 15, kMouthRight = 21;
  if (i == kJawRight || i == kMouthRight) return kArkitNames[i + 1];
  if (i == kJawRight + 1 || i == kMouthRight + 1) return kArkitNames[i - 1];
  return kArkitNames[i];
}

}  // namespace

math::AxisAngle TurnOf(const HeadAngles& angles) {
  const auto about = [&](size_t axis) {
    math::AxisAngle turn{};
    turn[axis] = angles[axis];
    return math::QuatOfAxisAngle(turn);
  };
  return math::AxisAngleOf(math::ShorterWay(
      math::Normalize(math::Multiply(math::Multiply(about(1), about(0)), about(2)))));
}

void AddScore(std::string_view name, double value, PhoneFrame& frame) {
  if (std::abs(value) <= double(kMaxScore))
    frame.scores[std::string(name)] = float(value);
  else
    frame.dropped.emplace_back(name);
}

float AngleOf(const std::string& source, const char* field, double angle, double unit) {
  if (!(std::abs(angle * unit) <= kMaxDegrees * kDegree))
    throw Error(source, field, Format("found {}, expected an angle of at most a full turn", angle));
  return float(angle * unit);
}

// Unity's left-handed axes: pitch is y and looks down, yaw is x and turns right, roll is z and
// leans to the left shoulder.
PhoneFrame ParseVtsFrame(const std::string& source, const std::string& packet) {
  if (std::count(packet.begin(), packet.end(), '[') +
          std::count(packet.begin(), packet.end(), '{') >
      kMaxVtsObjects)
    throw Error(source, Format("holds more than {} arrays and objects", kMaxVtsObjects));
  const JsonField object(source, ParseJson(source, packet));
  PhoneFrame frame;
  const JsonField found = object["FaceFound"];
  if (!found.raw().is_boolean()) found.Fail("is neither true nor false");
  frame.has_face = found.raw().get<bool>();
  if (!frame.has_face) return frame;
  const JsonField scores = object["BlendShapes"], turn = object["Rotation"];
  for (size_t i = 0; i < scores.size(); ++i) {
    const JsonField score = scores[i];
    AddScore(score["k"].String(), VtsNumber(score["v"]), frame);
  }
  const auto angle = [&](const char* axis, const char* field) {
    return AngleOf(source, field, VtsNumber(turn[axis]), kDegree);
  };
  frame.head = {angle("y", "Rotation.y"), -angle("x", "Rotation.x"), -angle("z", "Rotation.z")};
  return frame;
}

PhoneFrame ParseIFacialMocapFrame(const std::string& source, const std::string& packet) {
  constexpr std::string_view kHead = "head#";
  PhoneFrame frame;
  bool has_head = false;
  size_t parts = 0;
  for (std::string_view rest = packet; !rest.empty();) {
    std::string_view part = Trimmed(TakeUntil('|', rest));
    if (part.starts_with('=')) part.remove_prefix(1);
    if (part.empty()) continue;
    if (++parts > kMaxTextScores)
      throw Error(source, Format("holds more than {} parts", kMaxTextScores));
    if (part.starts_with(kHead)) {
      frame.head = IFacialMocapHead(source, part.substr(kHead.size()));
      has_head = true;
    } else if (part.find('#') == part.npos) {
      ReadIFacialMocapScore(part, frame);
    }  // else the eyes: where they look is in the scores
  }
  if (!has_head)
    throw Error(source, "head", "is missing: this is no whole frame of iFacialMocap's");
  return frame;
}

// Pitch looks up, yaw turns right, roll leans to the right shoulder.
PhoneFrame ParseLiveLinkFrame(const std::string& source, const std::string& packet) {
  ByteReader reader(packet);
  const std::string_view version = reader.Bytes(1);
  if (!reader.ok() || version[0] != kLiveLinkVersion)
    throw Error(source,
                "version",
                Format("found {}, expected {}: Live Link Face's mode ARKit",
                       version.empty() ? -1 : int(uint8_t(version[0])),
                       kLiveLinkVersion));
  reader.Bytes(reader.Word());  // the device's identifier
  reader.Bytes(reader.Word());  // the subject's name
  reader.Bytes(16);             // frame number, its fraction and the rate
  if (!reader.ok()) throw Error(source, "ends within the names");
  PhoneFrame frame;
  frame.has_face = !reader.empty();
  if (!frame.has_face) return frame;
  const int count = uint8_t(reader.Bytes(1)[0]);
  if (count != kLiveLinkNumbers)
    throw Error(source, "count", Format("found {}, expected {} numbers", count, kLiveLinkNumbers));
  for (size_t i = 0; i < kArkitBlendshapes; ++i)
    AddScore(LiveLinkName(i), double(reader.Float()), frame);
  const auto angle = [&](const char* field) {
    return AngleOf(source, field, double(reader.Float()), 1);
  };
  const float yaw = angle("head yaw"), pitch = angle("head pitch"), roll = angle("head roll");
  frame.head = {-pitch, -yaw, roll};
  reader.Bytes(6 * 4);  // the eyes: where they look is in the scores
  if (!reader.ok()) throw Error(source, "ends within the numbers");
  return frame;
}

}  // namespace cosplat

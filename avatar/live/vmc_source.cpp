#include <algorithm>
#include <array>
#include <cmath>

#include "avatar/live/osc.h"
#include "avatar/live/packet_input.h"
#include "avatar/live/scores_in_use.h"
#include "avatar/live/sender_clock.h"
#include "avatar/live/vrm_expressions.h"
#include "avatar/math/turn.h"
#include "avatar/model/avatar_mesh.h"

namespace cosplat {
namespace {

using math::AxisAngle;

// Per poll: about four frames of a sender with one datagram per blendshape and bone.
constexpr size_t kMaxPackets = 512;

// A sender that ends frames by itself is waited for no longer than this, by the clock of Poll.
constexpr int64_t kApplyPauseNs = 500'000'000;

constexpr std::string_view kValue = "/VMC/Ext/Blend/Val";
constexpr std::string_view kApply = "/VMC/Ext/Blend/Apply";
constexpr std::string_view kBone = "/VMC/Ext/Bone/Pos";
constexpr std::string_view kVmc = "/VMC/";

// By their normal names (NormalName), but for the order of "left" and "eye".
enum Bone : int { kNeck, kHead, kLeftEye, kRightEye, kOtherBone };
Bone FindBone(std::string_view name) {
  const std::string normal = NormalName(name);
  if (normal == "neck") return kNeck;
  if (normal == "head") return kHead;
  if (normal == "eyeleft" || normal == "lefteye") return kLeftEye;
  if (normal == "eyeright" || normal == "righteye") return kRightEye;
  return kOtherBone;
}

// The last values received; a frame is a copy of it.
struct VmcState {
  std::vector<float> scores;       // in the order of the map's names
  std::vector<float> expressions;  // weights of VRM's
  std::array<AxisAngle, kOtherBone> bones{};
};

// Whether an argument is a text and `numbers` finite numbers follow; further ones are left alone.
bool HasNameAndNumbers(const OscMessage& message, size_t numbers) {
  const std::vector<OscArgument>& arguments = message.arguments;
  bool good = arguments.size() > numbers && arguments[0].IsText();
  for (size_t i = 1; good && i <= numbers; ++i) good = arguments[i].IsNumber();
  return good;
}

// The text that a message begins with, or "".
std::string_view NameIn(const OscMessage& message) {
  return message.arguments.empty() ? std::string_view() : message.arguments[0].text;
}

// A bone's message contains its name, a position (3 numbers), and a quaternion as x, y, z, w.
math::Quat<float> BoneRotation(const OscMessage& message) {
  const auto number = [&](size_t i) { return float(message.arguments[i].number); };
  return {number(7), number(4), number(5), number(6)};
}

bool IsRotation(const math::Quat<float>& q) {
  const float length = std::hypot(std::hypot(q.w, q.x), std::hypot(q.y, q.z));
  return length > 0.5f && length < 2;
}

// Unity's axes are left-handed with x to the subject's right, FLAME's x points to the subject's
// left: the rotation is mirrored.
AxisAngle FlameTurn(const math::Quat<float>& bone) {
  const math::Quat<float> q = math::Normalize(bone);
  return math::AxisAngleOf(math::ShorterWay(math::Quat<float>{q.w, q.x, -q.y, -q.z}));
}

// A turn that is more than rounding, radians.
constexpr float kTurned = 1e-3f;

// What a message did.
enum class Use { kNone, kSet, kEndedFrame };

class VmcSource : public PacketSource {
 public:
  VmcSource(std::unique_ptr<PacketInput> input, ChosenMap chosen, const FlameParams& rest)
      : PacketSource(std::move(input), std::move(chosen), rest, kMaxPackets),
        expressions_(chosen_.map),
        own_(AllPlaces(chosen_.map)),
        gaze_(PlacesOfGaze(chosen_.map)) {
    state_.scores.resize(chosen_.map.names.size());
    state_.expressions.resize(expressions_.size());
  }

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    packets_.Clear();
    input_->Receive(packets_, counts_);
    const uint64_t before = applied_;
    for (size_t i = 0; i < packets_.size(); ++i) TakePacket(packets_[i], now_ns);
    if (set_ && !WaitsForApply(now_ns)) EndFrame(now_ns);
    if (applied_ == before) return false;
    counts_.replaced += applied_ - before - 1;
    ++counts_.frames;
    out.params.translation = {};
    out.params.pose = {frame_.bones[kNeck], frame_.bones[kHead]};
    ApplyBlendshapes(chosen_.map, frame_.scores, out.params);
    if (!gaze_.Are(frame_.scores, now_ns) && eye_bones_turned_)
      for (const Bone eye : {kLeftEye, kRightEye})
        if (eye_seen_[eye - kLeftEye]) out.params.pose[3 + eye - kLeftEye] = frame_.bones[eye];
    PutOnRest(rest_, out.params);
    out.sequence = applied_ - 1;
    out.time_ns = now_ns;
    return true;
  }

 private:
  // Whether the sender ends its frames by Apply. One that does not has a frame in each bundle, or
  // in what has arrived of single messages.
  bool WaitsForApply(int64_t now_ns) const {
    return apply_seen_ && ElapsedNs(apply_ns_, now_ns) < kApplyPauseNs;
  }

  // Trackers' own scores stand above VRM's expressions, which their senders often send as well:
  // both would open a mouth twice.
  void EndFrame(int64_t now_ns) {
    frame_ = state_;
    if (!own_.Are(frame_.scores, now_ns))
      expressions_.Add(frame_.expressions, frame_.scores);
    else if (std::any_of(frame_.expressions.begin(), frame_.expressions.end(), [](float x) {
               return x > 0;
             }))
      counts_.unused.blendshapes.Count("VRM's expressions beside scores");
    set_ = false;
    ++applied_;
  }

  void TakePacket(const std::string& packet, int64_t now_ns) {
    ParseOsc(packet, messages_);
    bool used = false;
    bad_ = nullptr;
    for (const OscMessage& message : messages_) {
      const Use use = message.problem.empty() ? Apply(message) : Drop(message, message.problem);
      used = used || use != Use::kNone;
      set_ = set_ || use == Use::kSet;
      if (use != Use::kEndedFrame) continue;
      apply_seen_ = true;
      apply_ns_ = now_ns;
      EndFrame(now_ns);
    }
    if (set_ && IsOscBundle(packet) && !WaitsForApply(now_ns)) EndFrame(now_ns);
    if (bad_)
      counts_.last_problem = input_->Description() + ": " +
                             (bad_->address.empty() ? "" : PrintableName(NameOf(*bad_)) + ": ") +
                             std::string(problem_);
    else if (!used)
      ++counts_.unusable;
  }

  // With what it is about: "/VMC/Ext/Bone/Pos Head".
  const std::string& NameOf(const OscMessage& message) {
    name_.assign(message.address);
    if (const std::string_view name = NameIn(message); !name.empty())
      name_.append(" ").append(name);
    return name_;
  }

  // Leaves a message out; what it would have set keeps its value.
  Use Drop(const OscMessage& message, std::string_view problem) {
    ++counts_.malformed;
    counts_.unused.dropped.Count(message.address.empty() ? "what is no OSC message"
                                                         : NameOf(message));
    bad_ = &message;
    problem_ = problem;
    return Use::kNone;
  }

  Use Apply(const OscMessage& message) {
    if (SameIgnoringCase(message.address, kApply)) return Use::kEndedFrame;
    if (SameIgnoringCase(message.address, kBone)) return TakeBone(message);
    if (SameIgnoringCase(message.address, kValue)) {
      if (!HasNameAndNumbers(message, 1))
        return Drop(message, "expected a name and 1 finite number");
      return TakeScore(message, message.arguments[0].text, message.arguments[1]);
    }
    // "/jawOpen", "/avatar/parameters/JawOpen"
    const std::string_view last = message.address.substr(message.address.rfind('/') + 1);
    if (SameIgnoringCase(message.address.substr(0, kVmc.size()), kVmc) ||
        FindArkitBlendshape(last) < 0) {
      counts_.unused.messages.Count(message.address);
      return Use::kNone;
    }
    if (message.arguments.empty() || !message.arguments[0].IsNumber())
      return Drop(message, "expected 1 finite number");
    return TakeScore(message, last, message.arguments[0]);
  }

  Use TakeScore(const OscMessage& message, std::string_view name, const OscArgument& value) {
    const int expression = index_.Find(name) < 0 ? expressions_.Find(name) : -1;
    const int i = expression < 0 ? FindScore(index_, name, counts_.unused) : expression;
    if (i < 0) return Use::kNone;
    if (!(std::abs(value.number) <= kMaxScore))
      return Drop(message, "is not a score, a number from 0 to 1");
    std::vector<float>& values = expression < 0 ? state_.scores : state_.expressions;
    values[size_t(i)] = float(std::clamp(value.number, 0.0, 1.0));
    return Use::kSet;
  }

  Use TakeBone(const OscMessage& message) {
    const Bone bone = FindBone(NameIn(message));
    if (bone == kOtherBone && HasNameAndNumbers(message, 0)) {
      counts_.unused.bones.Count(NameIn(message));
      return Use::kNone;
    }
    if (!HasNameAndNumbers(message, 7))
      return Drop(message, "expected a name and 7 finite numbers");
    const math::Quat<float> rotation = BoneRotation(message);
    if (!IsRotation(rotation)) return Drop(message, "its rotation is not a unit quaternion");
    state_.bones[bone] = FlameTurn(rotation);
    if (bone == kLeftEye || bone == kRightEye) {
      const AxisAngle& turn = state_.bones[bone];
      eye_seen_[bone - kLeftEye] = true;
      eye_bones_turned_ = eye_bones_turned_ || std::hypot(turn[0], turn[1], turn[2]) > kTurned;
    }
    return Use::kSet;
  }

  VrmExpressions expressions_;
  ScoresInUse own_, gaze_;
  std::vector<OscMessage> messages_;
  VmcState state_, frame_;  // current values; values at the end of the last frame
  bool set_ = false;        // whether they may differ
  bool apply_seen_ = false;
  int64_t apply_ns_ = 0;  // when, last
  std::array<bool, 2> eye_seen_{};
  bool eye_bones_turned_ = false;
  uint64_t applied_ = 0;  // number of complete frames
  // The last message dropped from the packet that is being read, or null, and why.
  const OscMessage* bad_ = nullptr;
  std::string_view problem_;
  std::string name_;  // scratch
};

}  // namespace

std::unique_ptr<LiveSource> OpenVmcSource(std::unique_ptr<PacketInput> input,
                                          ChosenMap map,
                                          const LiveSourceOptions& options) {
  return std::make_unique<VmcSource>(std::move(input), std::move(map), options.rest);
}

}  // namespace cosplat

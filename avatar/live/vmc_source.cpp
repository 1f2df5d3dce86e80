#include <algorithm>
#include <cmath>

#include "avatar/live/osc.h"
#include "avatar/live/packet_input.h"
#include "avatar/math/turn.h"
#include "avatar/model/avatar_mesh.h"

namespace cosplat {
namespace {

using math::AxisAngle;

// Per poll: about four frames of a sender with one datagram per blendshape and bone.
constexpr size_t kMaxPackets = 512;

constexpr std::string_view kValue = "/VMC/Ext/Blend/Val";
constexpr std::string_view kApply = "/VMC/Ext/Blend/Apply";
constexpr std::string_view kBone = "/VMC/Ext/Bone/Pos";

// The last values received; a frame is a copy of it.
struct VmcState {
  std::vector<float> scores;  // in the order of the map's names
  AxisAngle neck{}, head{};
};

// A bone's message contains its name, a position (3 numbers), and a quaternion as x, y, z, w.
math::Quat<float> BoneRotation(const OscMessage& message) {
  const auto number = [&](size_t i) { return float(message.arguments[i].number); };
  return {number(7), number(4), number(5), number(6)};
}

// Returns what is wrong with a message, or "". Messages that are not used are not checked.
std::string ProblemOf(const OscMessage& message) {
  const bool bone = message.address == kBone;
  if (!bone && message.address != kValue) return "";
  const std::vector<OscArgument>& arguments = message.arguments;
  bool good = arguments.size() == (bone ? 8 : 2) && arguments[0].IsText();
  for (size_t i = 1; good && i < arguments.size(); ++i) good = arguments[i].IsNumber();
  if (!good)
    return std::string(message.address) + ": expected a name and " + (bone ? "7" : "1") +
           " finite number" + (bone ? "s" : "");
  if (!bone) return "";
  const math::Quat<float> q = BoneRotation(message);
  const float length = std::hypot(std::hypot(q.w, q.x), std::hypot(q.y, q.z));
  if (length > 0.5f && length < 2) return "";
  return std::string(message.address) + ": its rotation is not a unit quaternion";
}

// Unity's axes are left-handed with x to the subject's right, FLAME's x points to the subject's
// left: the rotation is mirrored.
AxisAngle FlameTurn(const OscMessage& message) {
  const math::Quat<float> q = math::Normalize(BoneRotation(message));
  return math::AxisAngleOf(math::ShorterWay(math::Quat<float>{q.w, q.x, -q.y, -q.z}));
}

// Stores a message's value; returns true for the message that ends a frame.
bool Take(const OscMessage& message, const BlendshapeMap& map, VmcState& state) {
  if (message.address == kValue) {
    const int blendshape = FindBlendshape(map, message.arguments[0].text);
    if (blendshape >= 0)
      state.scores[blendshape] = float(std::clamp(message.arguments[1].number, 0.0, 1.0));
  } else if (message.address == kBone) {
    if (message.arguments[0].text == "Neck") state.neck = FlameTurn(message);
    if (message.arguments[0].text == "Head") state.head = FlameTurn(message);
  }
  return message.address == kApply;
}

class VmcSource : public LiveSource {
 public:
  VmcSource(std::unique_ptr<PacketInput> input, ChosenMap chosen, const FlameParams& rest)
      : input_(std::move(input)), chosen_(std::move(chosen)), rest_(rest) {
    state_.scores.resize(chosen_.map.names.size());
  }

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    packets_.Clear();
    input_->Receive(packets_, counts_);
    const uint64_t before = applied_;
    for (size_t i = 0; i < packets_.size(); ++i) TakePacket(packets_[i]);
    if (applied_ == before) return false;
    counts_.replaced += applied_ - before - 1;
    ++counts_.frames;
    out.params.translation = {};
    out.params.pose = {frame_.neck, frame_.head};
    ApplyBlendshapes(chosen_.map, frame_.scores, out.params);
    PutOnRest(rest_, out.params);
    out.sequence = applied_ - 1;
    out.time_ns = now_ns;
    return true;
  }

  bool Ended() const override { return input_->Ended(); }
  LiveCounts Counts() const override { return counts_; }
  std::string Description() const override {
    return input_->Description() + ", by " + chosen_.description;
  }

 private:
  // Applies all messages of a packet or, if one is bad, none.
  void TakePacket(const std::string& packet) {
    std::string problem = ParseOsc(packet, messages_);
    for (size_t i = 0; problem.empty() && i < messages_.size(); ++i)
      problem = ProblemOf(messages_[i]);
    if (!problem.empty()) {
      ++counts_.malformed;
      counts_.last_problem = input_->Description() + ": " + problem;
      return;
    }
    for (const OscMessage& message : messages_) {
      if (!Take(message, chosen_.map, state_)) continue;
      frame_ = state_;
      ++applied_;
    }
  }

  std::unique_ptr<PacketInput> input_;
  ChosenMap chosen_;
  FlameParams rest_;
  NewestPackets packets_{kMaxPackets};
  std::vector<OscMessage> messages_;
  VmcState state_, frame_;  // current values; values at the end of the last frame
  uint64_t applied_ = 0;    // number of complete frames
  LiveCounts counts_;
};

}  // namespace

std::unique_ptr<LiveSource> OpenVmcSource(std::unique_ptr<PacketInput> input,
                                          ChosenMap map,
                                          const LiveSourceOptions& options) {
  return std::make_unique<VmcSource>(std::move(input), std::move(map), options.rest);
}

}  // namespace cosplat

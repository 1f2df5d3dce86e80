#include <optional>

#include "avatar/live/packet_input.h"
#include "avatar/live/phone_frame.h"
#include "avatar/model/avatar_mesh.h"

namespace cosplat {
namespace {

// Per poll: ten times as many as a phone of 60 frames per second that is polled at 20 Hz.
constexpr size_t kMaxPhonePackets = 32;

class PhoneSource : public PacketSource {
 public:
  PhoneSource(std::unique_ptr<PacketInput> input,
              PhoneParser parse,
              ChosenMap chosen,
              const LiveSourceOptions& options,
              const HeadAngles& signs)
      : PacketSource(std::move(input), std::move(chosen), options.rest, kMaxPhonePackets),
        parse_(parse),
        signs_(signs),
        scores_(chosen_.map.names.size()) {}

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    std::optional<HeadAngles> head;  // of the newest frame
    TakePackets([&](const std::string& packet) {
      const PhoneFrame frame = parse_(input_->Description(), packet);
      if (!frame.has_face) {
        ++counts_.unusable;
        counts_.unused.messages.Count("no face");
        return;
      }
      TakeScores(frame.scores, frame.dropped, index_, input_->Description(), scores_, counts_);
      if (head) ++counts_.replaced;
      head = frame.head;
      ++sequence_;
    });
    if (!head) return false;
    ++counts_.frames;
    for (size_t i = 0; i < head->size(); ++i) (*head)[i] *= signs_[i];
    out.params.translation = {};
    out.params.pose = {TurnOf(*head)};
    ApplyBlendshapes(chosen_.map, scores_, out.params);
    PutOnRest(rest_, out.params);
    out.sequence = sequence_ - 1;
    out.time_ns = now_ns;
    return true;
  }

 private:
  PhoneParser parse_;
  HeadAngles signs_;
  std::vector<float> scores_;  // of the newest frame, in the order of the map's names
  uint64_t sequence_ = 0;      // number of frames
};

}  // namespace

std::unique_ptr<LiveSource> OpenPhoneSource(std::unique_ptr<PacketInput> input,
                                            PhoneParser parse,
                                            ChosenMap map,
                                            const LiveSourceOptions& options,
                                            const HeadAngles& signs) {
  return std::make_unique<PhoneSource>(std::move(input), parse, std::move(map), options, signs);
}

}  // namespace cosplat

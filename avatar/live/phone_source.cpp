#include <optional>

#include "avatar/live/packet_input.h"
#include "avatar/live/phone_frame.h"
#include "avatar/model/avatar_mesh.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// Per poll: ten times as many as a phone of 60 frames per second that is polled at 20 Hz.
constexpr size_t kMaxPhonePackets = 32;

class PhoneSource : public LiveSource {
 public:
  PhoneSource(std::unique_ptr<PacketInput> input,
              PhoneParser parse,
              ChosenMap chosen,
              const LiveSourceOptions& options,
              const HeadAngles& signs)
      : input_(std::move(input)),
        parse_(parse),
        chosen_(std::move(chosen)),
        index_(chosen_.map.names),
        rest_(options.rest),
        signs_(signs),
        scores_(chosen_.map.names.size()) {}

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    packets_.Clear();
    input_->Receive(packets_, counts_);
    std::optional<HeadAngles> head;  // of the newest frame
    for (size_t i = 0; i < packets_.size(); ++i) {
      try {
        const PhoneFrame frame = parse_(input_->Description(), packets_[i]);
        if (!frame.has_face) {
          ++counts_.unusable;
          counts_.unused.messages.Count("no face");
          continue;
        }
        TakeScores(frame.scores, frame.dropped, index_, input_->Description(), scores_, counts_);
        if (head) ++counts_.replaced;
        head = frame.head;
        ++sequence_;
      } catch (const Error& error) {
        ++counts_.malformed;
        counts_.last_problem = error.what();
      }
    }
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

  bool Ended() const override { return input_->Ended(); }
  LiveCounts Counts() const override { return counts_; }
  std::string Description() const override {
    return input_->Description() + ", by " + chosen_.description;
  }

 private:
  std::unique_ptr<PacketInput> input_;
  PhoneParser parse_;
  ChosenMap chosen_;
  BlendshapeIndex index_;
  FlameParams rest_;
  HeadAngles signs_;
  std::vector<float> scores_;  // of the newest frame, in the order of the map's names
  NewestPackets packets_{kMaxPhonePackets};
  uint64_t sequence_ = 0;  // number of frames
  LiveCounts counts_;
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

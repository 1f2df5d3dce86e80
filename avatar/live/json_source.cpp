#include <cmath>
#include <optional>

#include "avatar/live/json_frame.h"
#include "avatar/live/packet_input.h"
#include "avatar/live/sender_clock.h"
#include "avatar/model/avatar_mesh.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// Per poll: ten times as many as a sender of 120 frames per second that is polled at 40 Hz. Parsing
// this many of the largest packets takes a few milliseconds.
constexpr size_t kMaxPackets = 32;

class JsonSource : public LiveSource {
 public:
  JsonSource(std::unique_ptr<PacketInput> input, BlendshapeMap map, const FlameParams& rest)
      : input_(std::move(input)),
        map_(std::move(map)),
        index_(map_.names),
        rest_(rest),
        scores_(map_.names.size()) {}

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    packets_.Clear();
    input_->Receive(packets_, counts_);
    std::optional<JsonFrame> newest;
    for (size_t i = 0; i < packets_.size(); ++i) {
      try {
        JsonFrame frame = ParseJsonFrame(Description(), packets_[i]);
        if (!IsNewer(frame, now_ns)) continue;
        if (frame.blendshapes)
          TakeScores(*frame.blendshapes, frame.dropped, index_, Description(), scores_, counts_);
        if (newest) ++counts_.replaced;
        newest = std::move(frame);
      } catch (const Error& error) {
        ++counts_.malformed;
        counts_.last_problem = error.what();
      }
    }
    if (!newest) return false;
    ++counts_.frames;
    if (newest->blendshapes) ApplyBlendshapes(map_, scores_, newest->params);
    out.params = std::move(newest->params);
    PutOnRest(rest_, out.params);
    out.sequence = newest->sequence;
    out.time_ns =
        newest->time ? clock_.Received(std::llround(*newest->time * 1e9), now_ns) : now_ns;
    return true;
  }

  bool Ended() const override { return input_->Ended(); }
  LiveCounts Counts() const override { return counts_; }
  std::string Description() const override { return input_->Description(); }

 private:
  bool IsNewer(const JsonFrame& frame, int64_t now_ns) {
    if (order_.Accept(frame.sequence, now_ns)) {
      if (order_.began_again()) clock_ = {};  // the sender's clock may have restarted as well
      return true;
    }
    ++counts_.reordered;
    counts_.last_problem = Description() + ": seq: " + std::to_string(frame.sequence) +
                           " is not greater than the last sequence number";
    return false;
  }

  std::unique_ptr<PacketInput> input_;
  BlendshapeMap map_;
  BlendshapeIndex index_;
  FlameParams rest_;
  std::vector<float> scores_;  // of the newest frame that has some, in the order of the map's names
  NewestPackets packets_{kMaxPackets};
  SequenceFilter order_;
  SenderClock clock_;
  LiveCounts counts_;
};

}  // namespace

std::unique_ptr<LiveSource> OpenJsonSource(std::unique_ptr<PacketInput> input,
                                           ChosenMap map,
                                           const LiveSourceOptions& options) {
  return std::make_unique<JsonSource>(std::move(input), std::move(map.map), options.rest);
}

}  // namespace cosplat

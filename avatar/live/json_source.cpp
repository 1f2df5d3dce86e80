#include <cmath>
#include <optional>

#include "avatar/live/json_frame.h"
#include "avatar/live/packet_input.h"
#include "avatar/live/sender_clock.h"
#include "avatar/model/avatar_mesh.h"

namespace cosplat {
namespace {

// Per poll: ten times as many as a sender of 120 frames per second that is polled at 40 Hz. Parsing
// this many of the largest packets takes a few milliseconds.
constexpr size_t kMaxPackets = 32;

class JsonSource : public PacketSource {
 public:
  JsonSource(std::unique_ptr<PacketInput> input, ChosenMap chosen, const FlameParams& rest)
      : PacketSource(std::move(input), std::move(chosen), rest, kMaxPackets),
        scores_(chosen_.map.names.size()) {}

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    std::optional<JsonFrame> newest;
    TakePackets([&](const std::string& packet) {
      JsonFrame frame = ParseJsonFrame(Description(), packet);
      if (!IsNewer(frame, now_ns)) return;
      if (frame.blendshapes)
        TakeScores(*frame.blendshapes, frame.dropped, index_, Description(), scores_, counts_);
      if (newest) ++counts_.replaced;
      newest = std::move(frame);
    });
    if (!newest) return false;
    ++counts_.frames;
    if (newest->blendshapes) ApplyBlendshapes(chosen_.map, scores_, newest->params);
    out.params = std::move(newest->params);
    PutOnRest(rest_, out.params);
    out.sequence = newest->sequence;
    out.time_ns =
        newest->time ? clock_.Received(std::llround(*newest->time * 1e9), now_ns) : now_ns;
    return true;
  }

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

  std::vector<float> scores_;  // of the newest frame that has some, in the order of the map's names
  SequenceFilter order_;
  SenderClock clock_;
};

}  // namespace

std::unique_ptr<LiveSource> OpenJsonSource(std::unique_ptr<PacketInput> input,
                                           ChosenMap map,
                                           const LiveSourceOptions& options) {
  return std::make_unique<JsonSource>(std::move(input), std::move(map), options.rest);
}

}  // namespace cosplat

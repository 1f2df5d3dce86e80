#include "apps/cosplat/run/relay.h"

#include <algorithm>

#include "avatar/live/json_frame.h"

namespace cosplat {
namespace {

constexpr std::chrono::milliseconds kBetweenPolls{4};  // trackers send 60 frames per second

}  // namespace

Relay::Relay(std::unique_ptr<LiveSource> source, size_t expression_count)
    : source_(std::move(source)), thread_([=, this] { Run(expression_count); }) {}

Relay::~Relay() {
  ended_ = true;
  thread_.join();
}

void Relay::Run(size_t expression_count) {
  LiveFrame frame;
  while (!ended_) {
    const int64_t now =
        std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    if (!source_->Poll(now, frame)) {
      std::this_thread::sleep_for(kBetweenPolls);
      continue;
    }
    JsonFrame packet;
    packet.params = frame.params;
    packet.params.expression.resize(std::min(expression_count, frame.params.expression.size()));
    packet.time = 1e-9 * double(frame.time_ns);
    const std::lock_guard lock(mutex_);
    packet.sequence = ++number_;
    line_ = WriteJsonFrame(packet);
    came_.notify_all();
  }
  came_.notify_all();
}

std::string Relay::Next(uint64_t& seen, std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (!came_.wait_for(lock, patience, [&] { return number_ > seen || ended_; }) || ended_)
    return "";
  seen = number_;
  return line_;
}

}  // namespace cosplat

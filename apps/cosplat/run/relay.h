// A drive for pages, which have no UDP: its newest frame, for as many readers as come.
//
// LiveSource -> Relay -> lines of JSON (avatar/live/json_frame.h) -> `cosplat serve`, as
// server-sent events.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "avatar/live/source.h"

namespace cosplat {

class Relay {
 public:
  // source: its frames' roots are relative to a rest of zeros. expression_count: of the model;
  // further coefficients are left out.
  Relay(std::unique_ptr<LiveSource> source, size_t expression_count);
  ~Relay();
  // Waits for a line newer than number `seen` and sets `seen` to its own. Returns "" if none has
  // come within `patience`, or the relay ends. Thread-safe.
  std::string Next(uint64_t& seen, std::chrono::milliseconds patience);

 private:
  void Run(size_t expression_count);

  std::unique_ptr<LiveSource> source_;
  std::mutex mutex_;
  std::condition_variable came_;
  std::string line_;
  uint64_t number_ = 0;  // of lines so far
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

}  // namespace cosplat

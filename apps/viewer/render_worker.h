// Renders in a separate thread, so that the window stays responsive.
//
// Shot -> Start -> (thread) Stage -> TakeImage -> texture. The latest request wins: a shot that has
// not been started when the next one arrives is dropped.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/viewer/stage.h"

namespace cosplat::viewer {

struct RenderJob {
  Shot shot;
  int divisor = 1;        // the requested sides are divided by this
  int64_t input_ns = 0;   // time of the input that it shows
  bool may_stay = false;  // the image may stay on the device that renders it
};

// Passing it back to TakeImage reuses its memory.
struct FinishedImage {
  RenderJob job;
  std::string problem;  // why there is no image; otherwise it is in one of these:
  Image8 image;
  std::unique_ptr<DeviceImage> on_device;
  bool stayed = false;      // on the device; `image` is then empty
  double milliseconds = 0;  // render time
};

class RenderWorker {
 public:
  // Keeps a reference to `stage`, which nothing else may use from now on. `on_finished` is called
  // in the worker's thread after each image.
  RenderWorker(Stage& stage, std::function<void()> on_finished);
  ~RenderWorker();  // waits for the image that is being rendered

  void Start(RenderJob job);
  // Whether a job is running or waiting.
  bool Busy() const;
  // Swaps the newest image since the last call into `out`, whose memory is reused. Returns false if
  // there is none.
  bool TakeImage(FinishedImage& out);

 private:
  void Run();

  Stage& stage_;
  std::function<void()> on_finished_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<RenderJob> waiting_;
  FinishedImage finished_;
  bool drawing_ = false, has_finished_ = false, stop_ = false;
  std::thread thread_;
};

}  // namespace cosplat::viewer

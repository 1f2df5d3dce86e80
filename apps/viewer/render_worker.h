// Draws beside the window, so that it answers while an image is being made.
//
// Shot -> Start -> (thread) Stage -> Take -> texture. What is asked for last counts: a shot that
// has not begun when the next comes is not drawn.
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
  int divisor = 1;        // of the sides of the image that was wanted
  int64_t input_ns = 0;   // when what it shows came in
  bool may_stay = false;  // on the device, where one draws it
};

// Given back to Take, its memory is drawn into again.
struct FinishedImage {
  RenderJob job;
  std::string problem;  // why there is no image; otherwise it is in one of these:
  Image8 image;
  std::unique_ptr<DeviceImage> on_device;
  bool stayed = false;      // on the device; `image` is then empty
  double milliseconds = 0;  // that drawing took
};

class RenderWorker {
 public:
  // Keeps a reference to `stage`, which is its own from now on. `on_finished` is called in its
  // thread after each image.
  RenderWorker(Stage& stage, std::function<void()> on_finished);
  ~RenderWorker();  // waits for the image that is being drawn

  void Start(RenderJob job);
  // Whether a job is drawn or waits.
  bool Busy() const;
  // The newest image since the last call, into `out`, whose memory is used again. False where
  // there is none.
  bool Take(FinishedImage& out);

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

// Determines when the next frame of cosplatsrc is due, by counting or by the pipeline's clock.
#pragma once

#include <gst/gst.h>

#include <mutex>

namespace cosplat::gstreamer {

struct FrameTime {
  GstClockTime pts = 0;  // running time
  GstClockTime duration = 0;
  guint64 number = 0;  // since the element was started
  bool gap = false;    // preceding frames were skipped
};

// Frame n of a rate is at `origin` + n / rate. Each time is rounded separately, so that errors do
// not accumulate. One thread counts; any thread may unlock.
class FrameClock {
 public:
  // Restarts at frame 0.
  void Reset();
  // Sets the rate from the next frame on; 30000/1001 is 30000 frames in 1001 seconds.
  void SetRate(int fps_n, int fps_d);
  GstClockTime Duration() const;  // thread-safe

  FrameTime Next() const;
  // Waits for the first frame that has not ended yet; returns false if unlocked in the meantime.
  bool WaitForNext(GstElement* element, FrameTime& time);
  // Call after `time` was produced; advances to the next frame.
  void Made(const FrameTime& time);

  void Unlock();
  void UnlockStop();

 private:
  GstClockTime At(guint64 frame) const;
  bool WaitUntil(GstClock* clock, GstClockTime time);

  int fps_n_ = 1, fps_d_ = 1;
  GstClockTime origin_ = 0;   // running time of frame 0 at this rate
  guint64 frame_ = 0;         // next frame at this rate
  guint64 number_ = 0;        // next frame since the start
  mutable std::mutex mutex_;  // protects what other threads read or write
  GstClockID wait_ = nullptr;
  bool unlocked_ = false;
};

}  // namespace cosplat::gstreamer

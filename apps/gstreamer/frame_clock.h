// When the next frame of cosplatsrc is due: counted, or by the pipeline's clock.
#pragma once

#include <gst/gst.h>

#include <mutex>

namespace cosplat::gstreamer {

struct FrameTime {
  GstClockTime pts = 0;  // running time
  GstClockTime duration = 0;
  guint64 number = 0;  // since the element was started
  bool gap = false;    // frames before it were left out
};

// Frame n of a rate is at `origin` + n / rate, each rounded by itself, so that nothing drifts. One
// thread counts; any may unlock.
class FrameClock {
 public:
  // From the beginning.
  void Reset();
  // The rate from the next frame on; 30000/1001 is 30000 pictures in 1001 seconds.
  void SetRate(int fps_n, int fps_d);
  GstClockTime Duration() const;  // for any thread

  FrameTime Next() const;
  // The first frame that is not over yet, waited for; false if unlocked meanwhile.
  bool WaitForNext(GstElement* element, FrameTime& time);
  // It was made; the next one is due.
  void Made(const FrameTime& time);

  void Unlock();
  void UnlockStop();

 private:
  GstClockTime At(guint64 frame) const;
  bool WaitUntil(GstClock* clock, GstClockTime time);

  int fps_n_ = 1, fps_d_ = 1;
  GstClockTime origin_ = 0;   // running time of frame 0 at this rate
  guint64 frame_ = 0;         // the next, at this rate
  guint64 number_ = 0;        // the next, of all
  mutable std::mutex mutex_;  // over what other threads read or write
  GstClockID wait_ = nullptr;
  bool unlocked_ = false;
};

}  // namespace cosplat::gstreamer

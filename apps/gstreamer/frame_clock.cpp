#include "apps/gstreamer/frame_clock.h"

#include <algorithm>

namespace cosplat::gstreamer {

void FrameClock::Reset() {
  origin_ = 0;
  frame_ = number_ = 0;
}

void FrameClock::SetRate(int fps_n, int fps_d) {
  const std::lock_guard lock(mutex_);
  origin_ = At(frame_);
  frame_ = 0;
  fps_n_ = fps_n;
  fps_d_ = fps_d;
}

GstClockTime FrameClock::At(guint64 frame) const {
  return origin_ + gst_util_uint64_scale(frame, guint64(fps_d_) * GST_SECOND, guint64(fps_n_));
}

GstClockTime FrameClock::Duration() const {
  const std::lock_guard lock(mutex_);
  return gst_util_uint64_scale_int(GST_SECOND, fps_d_, fps_n_);
}

FrameTime FrameClock::Next() const {
  return {At(frame_), At(frame_ + 1) - At(frame_), number_, false};
}

bool FrameClock::WaitForNext(GstElement* element, FrameTime& time) {
  time = Next();
  GstClock* clock = gst_element_get_clock(element);
  if (!clock) return true;  // without a clock, do not wait
  const GstClockTime base = gst_element_get_base_time(element);
  const GstClockTime now = std::max(gst_clock_get_time(clock), base) - base;
  if (now > time.pts + time.duration) {
    const guint64 due =
        gst_util_uint64_scale(now - origin_, guint64(fps_n_), guint64(fps_d_) * GST_SECOND) + 1;
    time = {At(due), At(due + 1) - At(due), number_ + due - frame_, true};
  }
  const bool in_time = WaitUntil(clock, base + time.pts);
  gst_object_unref(clock);
  return in_time;
}

bool FrameClock::WaitUntil(GstClock* clock, GstClockTime time) {
  GstClockID wait;
  {
    const std::lock_guard lock(mutex_);
    if (unlocked_) return false;
    wait = wait_ = gst_clock_new_single_shot_id(clock, time);
  }
  const GstClockReturn result = gst_clock_id_wait(wait, nullptr);
  {
    const std::lock_guard lock(mutex_);
    wait_ = nullptr;
  }
  gst_clock_id_unref(wait);
  return result != GST_CLOCK_UNSCHEDULED;
}

void FrameClock::Made(const FrameTime& time) {
  frame_ += time.number - number_ + 1;
  number_ = time.number + 1;
}

void FrameClock::Unlock() {
  const std::lock_guard lock(mutex_);
  unlocked_ = true;
  if (wait_) gst_clock_id_unschedule(wait_);
}

void FrameClock::UnlockStop() {
  const std::lock_guard lock(mutex_);
  unlocked_ = false;
}

}  // namespace cosplat::gstreamer

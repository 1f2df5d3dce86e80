// Draws an avatar for OBS in a separate thread, so that neither OBS's graphics thread nor its
// window waits for a picture or for an avatar to be opened.
//
// settings -> PictureThread -> newest Picture -> AvatarSource.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "apps/hosts/avatar_view.h"

namespace cosplat::obs {

struct PictureSettings {
  hosts::ViewSettings view;
  hosts::Orbit orbit;
  hosts::Background background;
  uint32_t width = 0, height = 0;  // px
  double fps = 0;
  bool operator==(const PictureSettings&) const = default;
};

// BGRA, premultiplied, rows without padding. Empty while `width` is 0.
struct Picture {
  uint32_t width = 0, height = 0;  // px
  std::vector<uint8_t> pixels;
};

// All functions are thread-safe and do not wait for a picture.
class PictureThread {
 public:
  PictureThread();
  ~PictureThread();
  PictureThread(const PictureThread&) = delete;
  PictureThread& operator=(const PictureThread&) = delete;

  void Set(const PictureSettings& settings);
  // Nothing is drawn while the source is hidden.
  void SetShown(bool shown);
  // Swaps `picture` with the newest one; returns false if that was already taken.
  bool TakeImage(Picture& picture);
  // One line: the current problem or the state of the drive; "" before the first picture.
  std::string Status() const;

 private:
  using Clock = std::chrono::steady_clock;

  void Run();
  // Waits until a picture is due; returns false when the thread must stop.
  bool WaitForWork(PictureSettings& settings);
  void Draw(const PictureSettings& settings, Picture& picture);
  void Publish(Picture& picture, const std::string& status);
  void Fail(const std::string& problem);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  PictureSettings settings_;  // under the mutex, as all members up to the next comment
  Picture newest_;
  std::string status_;
  bool set_ = false;    // there are settings, and they have not failed
  bool dirty_ = false;  // the settings are new
  bool shown_ = false;
  bool fresh_ = false;  // the newest picture has not been taken
  bool stop_ = false;

  // Used by the thread only.
  hosts::ViewSettings open_;  // what `view_` was opened with
  std::unique_ptr<hosts::AvatarView> view_;
  Clock::time_point due_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace cosplat::obs

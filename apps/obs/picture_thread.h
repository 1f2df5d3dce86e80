// Draws an avatar for OBS beside it, so that neither its graphics thread nor its window waits for a
// picture, or for an avatar that is being opened.
//
// settings -> PictureThread -> Picture, the newest -> AvatarSource.
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

// BGRA, premultiplied, rows without gaps. Nothing is to be seen while `width` is 0.
struct Picture {
  uint32_t width = 0, height = 0;  // px
  std::vector<uint8_t> pixels;
};

// Its functions are for any thread and do not wait for a picture.
class PictureThread {
 public:
  PictureThread();
  ~PictureThread();
  PictureThread(const PictureThread&) = delete;
  PictureThread& operator=(const PictureThread&) = delete;

  void Set(const PictureSettings& settings);
  // Nothing is drawn for a source that nobody sees.
  void SetShown(bool shown);
  // Exchanges `picture` for the newest; false if that was taken already.
  bool Take(Picture& picture);
  // One line: what is wrong, or how the drive does; "" before the first picture.
  std::string Status() const;

 private:
  using Clock = std::chrono::steady_clock;

  void Run();
  // Waits until a picture is due; false at the end.
  bool WaitForWork(PictureSettings& settings);
  void Draw(const PictureSettings& settings, Picture& picture);
  void Publish(Picture& picture, const std::string& status);
  void Fail(const std::string& problem);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  PictureSettings settings_;  // under the mutex, as all up to the next comment
  Picture newest_;
  std::string status_;
  bool set_ = false;    // there are settings, and none that failed
  bool dirty_ = false;  // they are new
  bool shown_ = false;
  bool fresh_ = false;  // nobody took the newest yet
  bool stop_ = false;

  // The thread's own.
  hosts::ViewSettings open_;  // what `view_` was opened with
  std::unique_ptr<hosts::AvatarView> view_;
  Clock::time_point due_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace cosplat::obs

#include "avatar/play/playback.h"

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <utility>

namespace cosplat {

const RenderedImage* Playback::Next(PlaybackFrame frame) { return Step(std::move(frame)); }
const RenderedImage* Playback::Finish() { return Step(std::nullopt); }

std::exception_ptr Playback::Pose(const PlaybackFrame& frame, size_t place) {
  try {
    player_.Pose(frame.params, places_[place]);
    return nullptr;
  } catch (...) {
    return std::current_exception();
  }
}

const RenderedImage* Playback::Step(std::optional<PlaybackFrame> next) {
  // A repeated pose does not have to be placed again.
  const bool same_pose = next && places_[waiting_place_].IsFor(next->params);
  const size_t next_place = same_pose ? waiting_place_ : 1 - waiting_place_;
  std::exception_ptr next_error, error = waiting_error_;
  const RenderedImage* image = nullptr;
  tbb::task_group group;
  if (next && !same_pose) group.run([&] { next_error = Pose(*next, next_place); });
  if (waiting_ && !error) try {
      // Isolated, so that this thread does not start on the other frame while it waits for tiles.
      tbb::this_task_arena::isolate([&] {
        image = &player_.Draw(places_[waiting_place_], waiting_->camera, waiting_->background);
      });
      drawn_ = waiting_place_;
    } catch (...) {
      error = std::current_exception();
    }
  group.wait();
  waiting_ = std::move(next);
  waiting_error_ = next_error;
  waiting_place_ = next_place;
  if (error) std::rethrow_exception(error);
  return image;
}

}  // namespace cosplat

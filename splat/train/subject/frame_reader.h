// Frames that are not kept in memory: read again when they are needed, one of them ahead.
#pragma once

#include <future>

#include "splat/train/subject/subject.h"

namespace cosplat {

// The frame itself if its image is in memory, else `scratch`, into which it is read. May be called
// for several frames at once. Throws Error as TrainFrame::read does.
const TrainFrame& Loaded(const TrainFrame& frame, TrainFrame& scratch);

class FrameReader {
 public:
  // Begins to read the frame, which must outlive that, unless it is in memory.
  void Expect(const TrainFrame& frame);
  // As Loaded; valid until the next call.
  const TrainFrame& At(const TrainFrame& frame);

 private:
  TrainFrame current_;
  const TrainFrame* of_current_ = nullptr;
  std::future<TrainFrame> next_;
  const TrainFrame* of_next_ = nullptr;
};

}  // namespace cosplat

#include "splat/train/subject/frame_reader.h"

#include <utility>

namespace cosplat {

const TrainFrame& Loaded(const TrainFrame& frame, TrainFrame& scratch) {
  if (!frame.target.empty() || !frame.read) return frame;
  return scratch = frame.read();
}

void FrameReader::Expect(const TrainFrame& frame) {
  if (!frame.target.empty() || !frame.read || of_next_ == &frame || of_current_ == &frame) return;
  if (next_.valid()) next_.wait();
  of_next_ = &frame;
  next_ = std::async(std::launch::async, [&frame] { return frame.read(); });
}

const TrainFrame& FrameReader::At(const TrainFrame& frame) {
  if (!frame.target.empty() || !frame.read) return frame;
  if (of_current_ == &frame) return current_;
  of_current_ = nullptr;  // in case reading throws
  if (std::exchange(of_next_, of_next_ == &frame ? nullptr : of_next_) == &frame)
    current_ = next_.get();
  else
    current_ = frame.read();
  of_current_ = &frame;
  return current_;
}

}  // namespace cosplat

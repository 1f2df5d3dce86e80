// A live source that says once a second on standard error what it has received (`play --verbose`).
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "avatar/live/source.h"

namespace cosplat {

class VerboseSource : public LiveSource {
 public:
  explicit VerboseSource(std::unique_ptr<LiveSource> source) : source_(std::move(source)) {}
  ~VerboseSource() override { Say(); }

  bool Poll(int64_t now_ns, LiveFrame& out) override;
  bool Ended() const override { return source_->Ended(); }
  LiveCounts Counts() const override { return source_->Counts(); }
  std::string Description() const override { return source_->Description(); }

 private:
  // If it has changed since the last time.
  void Say();

  std::unique_ptr<LiveSource> source_;
  std::string said_;
  bool polled_ = false;
  int64_t said_ns_ = 0;
};

}  // namespace cosplat

// A live source that says once a second on standard error what it has received (`play --verbose`).
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "avatar/live/source.h"

namespace cosplat {

class VerboseSource : public LiveSource {
 public:
  explicit VerboseSource(std::unique_ptr<LiveSource> source) : source_(std::move(source)) {}
  ~VerboseSource() override { Say(); }

  bool Poll(int64_t now_ns, LiveFrame& out) override {
    const bool fresh = source_->Poll(now_ns, out);
    if (!polled_) said_ns_ = now_ns;
    polled_ = true;
    if (now_ns - said_ns_ >= 1'000'000'000) {
      Say();
      said_ns_ = now_ns;
    }
    return fresh;
  }
  bool Ended() const override { return source_->Ended(); }
  LiveCounts Counts() const override { return source_->Counts(); }
  std::string Description() const override { return source_->Description(); }

 private:
  // If it has changed since the last time.
  void Say() {
    const LiveCounts counts = source_->Counts();
    std::string text = source_->Description() + ": " + ToString(counts);
    if (!counts.last_problem.empty()) text += "; last problem: " + counts.last_problem;
    if (text == said_) return;
    std::fprintf(stderr, "%s\n", text.c_str());
    said_ = std::move(text);
  }

  std::unique_ptr<LiveSource> source_;
  std::string said_;
  bool polled_ = false;
  int64_t said_ns_ = 0;
};

}  // namespace cosplat

#include "apps/cosplat/run/verbose_source.h"

#include <cstdio>

namespace cosplat {

bool VerboseSource::Poll(int64_t now_ns, LiveFrame& out) {
  const bool fresh = source_->Poll(now_ns, out);
  if (!polled_) said_ns_ = now_ns;
  polled_ = true;
  if (now_ns - said_ns_ >= 1'000'000'000) {
    Say();
    said_ns_ = now_ns;
  }
  return fresh;
}

void VerboseSource::Say() {
  const LiveCounts counts = source_->Counts();
  std::string text = source_->Description() + ": " + ToString(counts);
  if (!counts.last_problem.empty()) text += "; last problem: " + counts.last_problem;
  if (text == said_) return;
  std::fprintf(stderr, "%s\n", text.c_str());
  said_ = std::move(text);
}

}  // namespace cosplat

#include "apps/cosplat/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace cosplat {

ProgressBar::ProgressBar(std::string title, int total, bool quiet)
    : title_(std::move(title)),
      total_(std::max(1, total)),
      visible_(!quiet && isatty(STDERR_FILENO)),
      start_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
  if (visible_) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::Update(int done, const std::string& detail) {
  if (!visible_) return;
  const auto now = std::chrono::steady_clock::now();
  if (done < total_ && now - drawn_ < std::chrono::milliseconds(100)) return;
  drawn_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = seconds > 0 ? done / seconds : 0;
  const int left = rate > 0 ? int((total_ - done) / rate) : 0;
  constexpr int kCells = 24;
  const int filled = int(int64_t(done) * kCells / total_);
  std::fprintf(stderr,
               "\r\033[K%s [%s%s] %d/%d  %s  %.1f it/s  %d:%02d left",
               title_.c_str(),
               std::string(filled, '=').c_str(),
               std::string(kCells - filled, ' ').c_str(),
               done,
               total_,
               detail.c_str(),
               rate,
               left / 60,
               left % 60);
  std::fflush(stderr);
}

void ProgressBar::Tell(const std::string& line) {
  std::fprintf(stderr, "%s%s\n", visible_ ? "\r\033[K" : "", line.c_str());
}

std::string WithThousands(size_t n) {
  std::string s = std::to_string(n);
  for (int i = int(s.size()) - 3; i > 0; i -= 3) s.insert(size_t(i), ",");
  return s;
}

}  // namespace cosplat

#include "apps/cosplat/run/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "splat/base/text.h"

namespace cosplat {

namespace {

constexpr int kLineEvery = 5;  // percent

}  // namespace

ProgressBar::ProgressBar(
    std::string title, int total, bool quiet, OffTerminal off_terminal, int first)
    : title_(std::move(title)),
      total_(std::max(1, total)),
      first_(first),
      visible_(!quiet && isatty(STDERR_FILENO)),
      lines_(!quiet && !visible_ && off_terminal == OffTerminal::kLines),
      start_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
  if (visible_) std::fprintf(stderr, "\r\033[K");
}

std::string ProgressBar::Status(int done, const std::string& detail) const {
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = seconds > 0 ? (done - first_) / seconds : 0;
  const int left = rate > 0 ? int((total_ - done) / rate) : 0;
  return Format(
      "{}/{}  {}  {:.1f} it/s  {}:{:02d} left", done, total_, detail, rate, left / 60, left % 60);
}

void ProgressBar::WriteLine(int done, const std::string& detail) {
  const int percent = int(int64_t(done) * 100 / total_) / kLineEvery * kLineEvery;
  if (percent <= written_) return;
  written_ = percent;
  std::fprintf(stderr, "%s %s\n", title_.c_str(), Status(done, detail).c_str());
}

void ProgressBar::Update(int done, const std::string& detail) {
  if (lines_) WriteLine(done, detail);
  if (!visible_) return;
  const auto now = std::chrono::steady_clock::now();
  if (done < total_ && now - drawn_ < std::chrono::milliseconds(100)) return;
  drawn_ = now;
  constexpr int kCells = 24;
  const int filled = int(int64_t(done) * kCells / total_);
  std::fprintf(stderr,
               "\r\033[K%s [%s%s] %s",
               title_.c_str(),
               std::string(filled, '=').c_str(),
               std::string(kCells - filled, ' ').c_str(),
               Status(done, detail).c_str());
  std::fflush(stderr);
}

void ProgressBar::Tell(const std::string& line) {
  std::fprintf(stderr, "%s%s\n", visible_ ? "\r\033[K" : "", line.c_str());
}

std::function<void(int done, int total)> ShowProgress(std::string title,
                                                      std::string detail,
                                                      bool quiet,
                                                      OffTerminal off_terminal) {
  return [=, bar = std::shared_ptr<ProgressBar>()](int done, int total) mutable {
    if (!bar) bar = std::make_shared<ProgressBar>(title, total, quiet, off_terminal);
    bar->Update(done, detail);
  };
}

}  // namespace cosplat

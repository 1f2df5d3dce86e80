// Shows the progress of a long task: on a terminal as one line that is redrawn; elsewhere (a log
// file) not at all, or as a new line every 5 %.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace cosplat {

enum class OffTerminal { kSilent, kLines };

class ProgressBar {
 public:
  // first: what was done before, by an interrupted run.
  ProgressBar(std::string title,
              int total,
              bool quiet = false,
              OffTerminal off_terminal = OffTerminal::kSilent,
              int first = 0);
  ~ProgressBar();
  // Redraws at most ten times per second; `detail` is shown after the bar, or in the log line.
  void Update(int done, const std::string& detail);
  // Prints a line above the bar.
  void Tell(const std::string& line);

 private:
  // Progress, `detail`, speed and remaining time.
  std::string Status(int done, const std::string& detail) const;
  void WriteLine(int done, const std::string& detail);

  std::string title_;
  int total_, first_;
  bool visible_, lines_;
  int written_ = 0;  // percentage in the last line written
  std::chrono::steady_clock::time_point start_, drawn_;
};

// For tasks that say how much is done of how much: a bar that begins with the first call.
std::function<void(int done, int total)> ShowProgress(
    std::string title,
    std::string detail,
    bool quiet = false,
    OffTerminal off_terminal = OffTerminal::kSilent);

}  // namespace cosplat

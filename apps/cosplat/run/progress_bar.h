// Shows how far long work has come: on a terminal one line that is redrawn; elsewhere (a log file)
// nothing, or a new line at every 5 %.
#pragma once

#include <chrono>
#include <string>

namespace cosplat {

enum class OffTerminal { kSilent, kLines };

class ProgressBar {
 public:
  ProgressBar(std::string title,
              int total,
              bool quiet = false,
              OffTerminal off_terminal = OffTerminal::kSilent);
  ~ProgressBar();
  // Redraws at most ten times a second; `detail` stands after the bar, or in the line.
  void Update(int done, const std::string& detail);
  // A line above the bar.
  void Tell(const std::string& line);

 private:
  // How far, with which detail, how fast and how long still.
  std::string Status(int done, const std::string& detail) const;
  void WriteLine(int done, const std::string& detail);

  std::string title_;
  int total_;
  bool visible_, lines_;
  int written_ = 0;  // percent, in the last line
  std::chrono::steady_clock::time_point start_, drawn_;
};

// 12345 -> "12,345".
std::string WithThousands(size_t n);

}  // namespace cosplat

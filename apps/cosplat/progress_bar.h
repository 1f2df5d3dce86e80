// One line that shows how far long work has come. Silent when standard error is not a terminal.
#pragma once

#include <chrono>
#include <string>

namespace cosplat {

class ProgressBar {
 public:
  ProgressBar(std::string title, int total, bool quiet = false);
  ~ProgressBar();
  // Redraws at most ten times a second; `detail` stands after the bar.
  void Update(int done, const std::string& detail);
  // A line above the bar.
  void Tell(const std::string& line);

 private:
  std::string title_;
  int total_;
  bool visible_;
  std::chrono::steady_clock::time_point start_, drawn_;
};

// 12345 -> "12,345".
std::string WithThousands(size_t n);

}  // namespace cosplat

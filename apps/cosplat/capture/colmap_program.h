// COLMAP as a program that is started: `colmap COMMAND OPTIONS`. Its commands and options changed
// between 3.8 and 4.2, without aliases, so which ones it has is asked of itself (`colmap help`,
// `colmap COMMAND -h`), once per run; colmap.h says what is done with it.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace cosplat {

// A value with the names that versions of COLMAP have for it ("--SiftExtraction.use_gpu"): it is
// passed under the first that the program takes.
struct ColmapOption {
  std::vector<std::string> names;
  std::string value;
  bool required = true;  // else left out where the program takes none of the names
};
using ColmapOptions = std::vector<ColmapOption>;

class ColmapProgram {
 public:
  // path: of the executable. Throws Error if it cannot be started or is no COLMAP.
  explicit ColmapProgram(std::string path);

  bool Has(const std::string& command) const { return commands_.contains(command); }
  bool Takes(const std::string& command, const std::string& option);

  // What to start the command with, its path first. Throws Error naming the command and an option
  // that is required and not taken.
  std::vector<std::string> Arguments(const std::string& command, const ColmapOptions& options);

 private:
  const std::set<std::string>& OptionsOf(const std::string& command);

  std::string path_;
  std::set<std::string> commands_;
  std::map<std::string, std::set<std::string>> options_;  // by command, of those asked so far
};

// Runs commands one after another, with a bar of their progress, and keeps what they print.
class ColmapRunner {
 public:
  // log: the file that all output is appended to; photographs: how many there are, for the bar.
  ColmapRunner(ColmapProgram& program, std::string log, int photographs, bool quiet)
      : program_(program), log_(std::move(log)), photographs_(photographs), quiet_(quiet) {}

  // Returns the exit status (process.h). `title`: of the bar.
  int TryRun(const std::string& title, const std::string& command, const ColmapOptions& options);
  // Throws Error if the command fails.
  void Run(const std::string& title, const std::string& command, const ColmapOptions& options);
  // Prints the command's last lines to standard error and throws Error.
  [[noreturn]] void Fail(const std::string& command, int status) const;

 private:
  void Remember(const std::string& line);

  ColmapProgram& program_;
  std::string log_;
  int photographs_;
  bool quiet_;
  std::deque<std::string> tail_;
};

}  // namespace cosplat

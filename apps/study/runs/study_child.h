// Runs the steps of a study as child processes, each as a user would run it.
#pragma once

#include <signal.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace cosplat {

// The user interrupted the study (SIGINT, SIGTERM); no child process is left.
struct StudyStopped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// While it exists, SIGINT and SIGTERM are deferred to the next call of Run. Create it before any
// threads.
class StudyChildren {
 public:
  StudyChildren();
  ~StudyChildren();
  StudyChildren(const StudyChildren&) = delete;
  StudyChildren& operator=(const StudyChildren&) = delete;

  // Runs the command with its arguments, by `cosplat-study` if it trains, otherwise by `cosplat`,
  // and discards its standard output. Throws Error with the command if it fails, and StudyStopped.
  void Run(const std::vector<std::string>& arguments) const;

 private:
  sigset_t waited_for_, before_;
};

}  // namespace cosplat

// Runs this program again as a child process: the steps of a study, each as a user would give it.
#pragma once

#include <signal.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace cosplat {

// The user stopped it (SIGINT, SIGTERM); no child is left.
struct StudyStopped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// While it lives, SIGINT and SIGTERM wait for the next call of Run. To be made before threads are.
class StudyChildren {
 public:
  StudyChildren();
  ~StudyChildren();
  StudyChildren(const StudyChildren&) = delete;
  StudyChildren& operator=(const StudyChildren&) = delete;

  // `cosplat` with the arguments; what it prints to standard output is dropped. Throws Error with
  // its command when it fails, StudyStopped.
  void Run(const std::vector<std::string>& arguments) const;

 private:
  sigset_t waited_for_, before_;
};

}  // namespace cosplat

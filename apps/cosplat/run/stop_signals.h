// Ctrl-C and SIGTERM, deferred to a moment at which a run can be interrupted.
#pragma once

#include <csignal>
#include <stdexcept>
#include <string>

namespace cosplat {

// The run was interrupted by a signal and can be resumed. The process exits with 128 + signal.
struct Stopped : std::runtime_error {
  Stopped(int signal, const std::string& message) : std::runtime_error(message), signal(signal) {}
  int signal;
};

// While it exists, the first SIGINT or SIGTERM is only noted; a second one has its usual effect.
// One at a time. Signals that this process ignores stay ignored.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // The signal that was noted; 0: none.
  int received() const;

 private:
  struct sigaction interrupt_, terminate_;  // as they were
};

}  // namespace cosplat

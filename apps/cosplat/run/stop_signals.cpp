#include "apps/cosplat/run/stop_signals.h"

#include <atomic>

namespace cosplat {
namespace {

std::atomic<int> noted_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler sets it");

void Note(int signal) { noted_signal = signal; }

struct sigaction HandlerOf(int signal) {
  struct sigaction before {};
  sigaction(signal, nullptr, &before);
  return before;
}

void Defer(int signal, const struct sigaction& before) {
  if (before.sa_handler == SIG_IGN) return;
  struct sigaction action {};
  action.sa_handler = Note;
  action.sa_flags = int(SA_RESTART | SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

StopSignals::StopSignals() : interrupt_(HandlerOf(SIGINT)), terminate_(HandlerOf(SIGTERM)) {
  noted_signal = 0;
  Defer(SIGINT, interrupt_);
  Defer(SIGTERM, terminate_);
}

StopSignals::~StopSignals() {
  sigaction(SIGINT, &interrupt_, nullptr);
  sigaction(SIGTERM, &terminate_, nullptr);
}

int StopSignals::received() const { return noted_signal; }

}  // namespace cosplat

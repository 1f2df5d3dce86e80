// Seconds spent per phase of a step.
#pragma once

#include <array>
#include <chrono>
#include <ctime>

namespace cosplat {

enum class Phase {
  kPose,
  kProject,
  kSort,
  kBlend,
  kLoss,
  kBackward,
  kAdam,
  kDensity,
  kData,
  kCount
};
constexpr std::array<const char*, size_t(Phase::kCount)> kPhaseNames{
    "pose", "project", "sort", "blend", "loss", "backward", "adam", "density", "data"};

struct PhaseTimes {
  std::array<double, size_t(Phase::kCount)> seconds{};
  PhaseTimes& operator+=(const PhaseTimes& other) {
    for (size_t i = 0; i < seconds.size(); ++i) seconds[i] += other.seconds[i];
    return *this;
  }
};

// CPU time of all threads of this process, in seconds.
inline double ProcessorSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// Adds the time between its construction and destruction to one phase.
class ScopedPhase {
 public:
  ScopedPhase(PhaseTimes& times, Phase phase)
      : times_(times), phase_(phase), start_(std::chrono::steady_clock::now()) {}
  ~ScopedPhase() {
    times_.seconds[size_t(phase_)] +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  ScopedPhase(const ScopedPhase&) = delete;
  ScopedPhase& operator=(const ScopedPhase&) = delete;

 private:
  PhaseTimes& times_;
  Phase phase_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace cosplat

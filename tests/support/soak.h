// A long live show through the C interface: LiveStory, drawn frame by frame, and what became of
// memory, time and images. A test runs a short one, tests/bench/plugin_bench.cpp two hours.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "avatar/plugin/cosplat.h"
#include "tests/support/live_story.h"

namespace cosplat::test {

// Resident memory of the process.
inline double ResidentMegabytes() {
  size_t size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return double(resident) * double(sysconf(_SC_PAGESIZE)) / 1e6;
}

// `values` must not be empty; sorts them.
inline double Quantile(std::vector<float>& values, double share) {
  std::sort(values.begin(), values.end());
  return values[size_t(share * double(values.size() - 1))];
}

inline double MillisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

struct SoakReport {
  double first_mb = 0, last_mb = 0;                   // after the first tenth and at the end
  double median_ms = 0, slow_ms = 0, slowest_ms = 0;  // per frame; the second of 99 %
  int unexpected = 0;                                 // calls that did not return what they should
  int checkpoints = 0;
  int unlike_replayed = 0;  // images that a new avatar with the same inputs draws otherwise
  int plain = 0;            // checkpoints whose face was live
  int unlike_plain = 0;     // of those, images that a new avatar with that frame draws otherwise
  cosplat_health health{};
  uint64_t bad = 0, late = 0;
};

class Soak {
 public:
  struct Settings {
    std::string avatar_path, flame_path;
    int frames = 0;
    int checkpoints = 0;  // such that they do not fall on the same part of every act
    uint32_t side = 0;
  };

  Soak(const FlameModel& flame, const Settings& settings)
      : flame_(flame), settings_(settings), pixels_(size_t(4) * settings.side * settings.side) {}

  SoakReport Run() {
    cosplat_avatar* avatar = Open();
    LiveStory story(flame_);
    // All memory of the measurement itself is there from the start.
    kept_.assign(size_t(settings_.checkpoints), {-1, pixels_});
    std::vector<float> times(size_t(settings_.frames), 0.0f);
    for (int f = 0; f < settings_.frames; ++f) {
      const auto start = std::chrono::steady_clock::now();
      report_.unexpected += !story.Feed(avatar, f);
      Draw(avatar, f);
      times[size_t(f)] = float(MillisecondsSince(start));
      if (f == settings_.frames / 10) report_.first_mb = ResidentMegabytes();
      if (IsCheckpoint(f)) Keep(avatar, story.newest());
    }
    report_.last_mb = ResidentMegabytes();
    report_.health = HealthOf(avatar);
    report_.bad = story.bad();
    report_.late = story.late();
    report_.median_ms = Quantile(times, 0.5);
    report_.slow_ms = Quantile(times, 0.99);
    report_.slowest_ms = times.back();
    cosplat_close(avatar);
    Replay();
    ComparePlain();
    return report_;
  }

 private:
  struct Checkpoint {
    int frame = -1;  // whose parameters are shown; -1: not one alone
    std::vector<uint8_t> pixels;
  };

  cosplat_avatar* Open() {
    cosplat_open_options options = {};
    options.struct_size = sizeof(options);
    options.flame_path = settings_.flame_path.c_str();
    cosplat_avatar* avatar = nullptr;
    report_.unexpected +=
        cosplat_open(settings_.avatar_path.c_str(), &options, &avatar) != COSPLAT_OK;
    return avatar;
  }

  bool IsCheckpoint(int frame) const {
    const int every = settings_.frames / settings_.checkpoints;
    return (frame + 1) % every == 0 && (frame + 1) / every <= settings_.checkpoints;
  }

  static cosplat_health HealthOf(cosplat_avatar* avatar) {
    cosplat_health health = {};
    health.struct_size = sizeof(health);
    cosplat_get_health(avatar, &health);
    return health;
  }

  void Render(cosplat_avatar* avatar) {
    cosplat_picture image = {};
    image.struct_size = sizeof(image);
    image.width = image.height = settings_.side;
    image.pixels = pixels_.data();
    report_.unexpected += cosplat_render(avatar, &image) != COSPLAT_OK;
  }
  void Draw(cosplat_avatar* avatar, int frame) {
    report_.unexpected += cosplat_advance(avatar, frame * LiveStory::kStepNs) != COSPLAT_OK;
    Render(avatar);
  }

  void Keep(cosplat_avatar* avatar, int frame) {
    const bool live = HealthOf(avatar).face == COSPLAT_FACE_LIVE;
    Checkpoint& kept = kept_[size_t(report_.checkpoints++)];
    kept.frame = live ? frame : -1;
    kept.pixels = pixels_;
  }

  // All inputs again, with images at the checkpoints only.
  void Replay() {
    cosplat_avatar* avatar = Open();
    LiveStory story(flame_);
    size_t checkpoint = 0;
    for (int f = 0; f < settings_.frames; ++f) {
      story.Feed(avatar, f);
      if (!IsCheckpoint(f)) {
        cosplat_advance(avatar, f * LiveStory::kStepNs);
        continue;
      }
      Draw(avatar, f);
      report_.unlike_replayed += pixels_ != kept_[checkpoint++].pixels;
    }
    cosplat_close(avatar);
  }

  void ComparePlain() {
    for (const Checkpoint& kept : kept_) {
      if (kept.frame < 0) continue;
      cosplat_avatar* avatar = Open();
      LiveStory story(flame_);
      const cosplat_parameters p = story.ParametersFor(kept.frame);
      cosplat_set_parameters(avatar, &p);
      Render(avatar);
      ++report_.plain;
      report_.unlike_plain += pixels_ != kept.pixels;
      cosplat_close(avatar);
    }
  }

  const FlameModel& flame_;
  Settings settings_;
  std::vector<uint8_t> pixels_;
  std::vector<Checkpoint> kept_;
  SoakReport report_;
};

}  // namespace cosplat::test

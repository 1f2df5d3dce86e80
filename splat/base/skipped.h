// What is wrong with a data set: unusable frames, which are skipped, counted and listed, up to a
// third of all frames; and what a check of it found.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "splat/base/error.h"

namespace cosplat {

struct SkippedFrame {
  std::string name;
  std::string reason;
};

// The message of the Error that `load` throws; else what it returns, if that is text, or an empty
// string. For frames that may be skipped.
template <class F>
std::string Problem(const F& load) {
  try {
    if constexpr (std::is_same_v<decltype(load()), std::string>)
      return load();
    else
      load();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// Those of `all` that have no problem; the others go to `skipped`, under the name that
// name_of(T) gives.
template <class T, class F>
std::vector<T> KeepUsable(std::vector<T> all,
                          const std::vector<std::string>& problems,
                          const F& name_of,
                          std::vector<SkippedFrame>& skipped) {
  std::vector<T> usable;
  for (size_t i = 0; i < all.size(); ++i)
    if (problems[i].empty())
      usable.push_back(std::move(all[i]));
    else
      skipped.push_back({name_of(all[i]), problems[i]});
  return usable;
}

// Throws Error(source, ...) if no frame is usable or more than a third of all frames were skipped;
// the message has the counts and the first reasons.
void CheckSkipped(const std::string& source,
                  size_t usable,
                  const std::vector<SkippedFrame>& skipped);

// What a check found before the data are trained on: CheckScene (splat/io/scene_check.h),
// CheckTrack (flame/track.h); `cosplat check` and the trainers print it.
struct Finding {
  bool wrong = false;  // it trains, but not what the user meant; else worth knowing
  std::string text;    // one sentence: the figure, and what to do
};

// Adds a finding if any were skipped, wrong if more than a third of all were. what: of which images
// they are `skipped.size()`, as in "images looked at".
void NoteSkipped(size_t usable,
                 const std::vector<SkippedFrame>& skipped,
                 const std::string& what,
                 std::vector<Finding>& findings);

inline bool AnyWrong(const std::vector<Finding>& findings) {
  return std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.wrong; });
}

}  // namespace cosplat

// Unusable frames of a data set: they are skipped, counted and listed, up to a third of all frames.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "splat/base/error.h"

namespace cosplat {

struct SkippedFrame {
  std::string name;
  std::string reason;
};

// Returns the message of the Error that `load` throws, or an empty string if it throws none. For
// frames that may be skipped.
template <class F>
std::string Problem(const F& load) {
  try {
    load();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// Throws Error(source, ...) if no frame is usable or more than a third of all frames were skipped;
// the message has the counts and the first reasons.
void CheckSkipped(const std::string& source,
                  size_t usable,
                  const std::vector<SkippedFrame>& skipped);

}  // namespace cosplat

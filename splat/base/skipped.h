// Frames of a data set that cannot be used: skipped, counted and listed, up to a third of them.
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

// What `load` throws as an Error, as text; empty when it does not. For frames that may be skipped.
template <class F>
std::string Problem(const F& load) {
  try {
    load();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// Throws Error(source, ...) when no frame is usable or when more than a third of all frames were
// skipped; the message gives the counts and the first reasons.
void CheckSkipped(const std::string& source,
                  size_t usable,
                  const std::vector<SkippedFrame>& skipped);

}  // namespace cosplat

// Splat files as the commands read them: what was made of odd values, or left out, is said.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/io/splat_file.h"

namespace cosplat {

// ReadSplats (splat/io/splat_file.h), with a line on stderr for each of its notes.
inline Gaussians ReadSplatsAloud(const std::string& path) {
  std::vector<std::string> notes;
  Gaussians gaussians = ReadSplats(path, &notes);
  for (const std::string& note : notes)  // on one line, as errors are
    std::fprintf(stderr, "cosplat: %s\n", Error(path, note).what());
  return gaussians;
}

}  // namespace cosplat

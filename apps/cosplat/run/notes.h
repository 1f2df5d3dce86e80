// What a user should know of the data, on stderr or stdout: how files were read, what checks of it
// found (CheckScene, CheckTrack), which frames were left out.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "splat/base/skipped.h"
#include "splat/gaussians.h"

namespace cosplat {

// A line each on stderr.
inline void PrintNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) std::fprintf(stderr, "cosplat: note: %s\n", note.c_str());
}

// ReadSplats (splat/io/splat_file.h), with a line on stderr for each of its notes.
Gaussians ReadSplatsAloud(const std::string& path);

// A block of lines, what is wrong first; "the data tells one story" if there are none.
std::string ToString(const std::vector<Finding>& findings);

// Before training: prints the block on stderr, if there is any. Throws Error if something is wrong
// and `strict`.
void PrintFindings(const std::string& source, const std::vector<Finding>& findings, bool strict);

// Prints the number of skipped frames, and up to five of them with their reasons.
void PrintSkipped(const std::vector<SkippedFrame>& skipped);

}  // namespace cosplat

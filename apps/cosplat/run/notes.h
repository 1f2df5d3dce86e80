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

// Before training: prints the block on stderr, if there is any (`quiet`: if something is wrong),
// and returns whether the data tells one story. Throws Error if something is wrong and `strict`.
bool PrintFindings(const std::string& source,
                   const std::vector<Finding>& findings,
                   bool strict,
                   bool quiet);

constexpr int kSomethingWrong = 3;  // exit code: results are whole, but of data that is wrong

// Ends a command that made all it was asked for of data that is wrong: a line on stderr, and that
// exit code.
[[noreturn]] void EndAsWrong(const std::string& source);

// Prints the number of skipped frames, and up to five of them with their reasons.
void PrintSkipped(const std::vector<SkippedFrame>& skipped);

}  // namespace cosplat

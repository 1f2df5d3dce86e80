// What a user should know of how a file was read: a line each on stderr.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace cosplat {

inline void PrintNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) std::fprintf(stderr, "cosplat: note: %s\n", note.c_str());
}

}  // namespace cosplat

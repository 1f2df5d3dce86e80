// The photographs that `scene` finds cameras for: those of a folder, or frames of a video.
#pragma once

#include <string>
#include <vector>

#include "splat/base/json.h"
#include "splat/base/skipped.h"

namespace cosplat {

struct Photographs {
  std::vector<std::string> names;  // below the folder they were gathered in, sorted
  int lenses = 1;  // more than one: those of each (by size and focal length) have a subfolder
  bool is_video = false;              // consecutive in time
  int width = 0, height = 0;          // px, the largest
  std::vector<SkippedFrame> skipped;  // damaged files
};

// What tells one input from another: path, bytes and time of change of each photograph or of the
// video. Throws Error if `source` is neither a folder that contains photographs nor a file.
Json IdentityOf(const std::string& source);

// Fills `folder` with links to the photographs of `source`, with turned copies of those that their
// EXIF orientation says lie on their side, or with the sharpest of `frames` intervals of a video.
// Damaged files are skipped, up to a third. Throws Error if fewer than kMinPhotographs are left.
Photographs GatherPhotographs(const std::string& source,
                              int frames,
                              const std::string& folder,
                              bool quiet);
constexpr size_t kMinPhotographs = 3;

Json ToJson(const Photographs& photographs);
Photographs PhotographsFromJson(const JsonField& json);

}  // namespace cosplat

// Whose face is whose in a video that may show several people, and which of them is meant.
#pragma once

#include <optional>
#include <vector>

#include "flame/fit/face_box.h"

namespace cosplat {

// The one who is seen largest for longest.
struct Person {
  std::vector<std::optional<size_t>> face;  // [frames] which of the frame's faces; none: not seen
  double next = 0;                          // as much, of who comes next, in parts of the first's
  // [frames] where the others' faces are: theirs who are seen a third as much at least, which no
  // picture on the wall is, and nothing that was taken for a face.
  std::vector<std::vector<LandmarkBox>> others;
};

// boxes: [frames][faces], in order of time. Faces follow each other by place and size; where there
// is but one, it may be anywhere.
Person ChoosePerson(const std::vector<std::vector<LandmarkBox>>& boxes);

// Leaves each frame the face of that person alone, who is returned.
Person KeepPerson(std::vector<std::vector<DetectedFace>>& frames);

}  // namespace cosplat

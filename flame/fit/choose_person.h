// Whose face is whose in a video that may show several people, and which of them is meant.
#pragma once

#include <optional>
#include <vector>

#include "flame/io/landmarks.h"

namespace cosplat {

// One of the people, and the others who are seen a third as much at least (size times frames):
// which no picture on the wall is, and nothing that was taken for a face.
struct Person {
  std::vector<std::optional<size_t>> face;   // [frames] which of the frame's; none: not seen
  std::vector<std::vector<FaceBox>> others;  // [frames] where their faces are
  bool is_alone = true;
};

// Of those who stay, the one who is seen largest for longest, or nearest to where a look at fewer
// frames saw whom it chose. boxes: [frames][faces], in order of time. Faces follow each other by
// place and size; where there is but one, it may be anywhere. expected: [frames], or none.
Person ChoosePerson(const std::vector<std::vector<FaceBox>>& boxes,
                    const std::vector<FaceBox>& expected = {});

// Leaves each frame the face of that person alone, who is returned.
Person KeepPerson(std::vector<std::vector<DetectedFace>>& frames,
                  const std::vector<FaceBox>& expected = {});

}  // namespace cosplat

#include "apps/cosplat/capture/sharp_frames.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

#include "apps/cosplat/run/notes.h"
#include "splat/media/image_io.h"

namespace cosplat {

double Sharpness(const Image8& image) {
  if (image.width < 3 || image.height < 3) return 0;
  const int green = image.channels < 3 ? 0 : 1;
  double sum = 0, squares = 0;
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x) {
      const double laplacian = image.at(x - 1, y, green) + image.at(x + 1, y, green) +
                               image.at(x, y - 1, green) + image.at(x, y + 1, green) -
                               4 * image.at(x, y, green);
      sum += laplacian;
      squares += laplacian * laplacian;
    }
  const double n = double(image.width - 2) * (image.height - 2);
  return squares / n - (sum / n) * (sum / n);
}

std::vector<std::string> WriteSharpFrames(
    const std::string& video,
    int count,
    const std::string& folder,
    const std::function<void(int done, int total)>& progress) {
  VideoReader reader(video);
  PrintNotes(reader.notes());
  const int total = reader.frame_count();
  const int intervals = std::min(count, total);
  std::vector<std::string> names;
  for (int i = 0, next = 0; i < intervals; ++i) {
    const int end = int(int64_t(i + 1) * total / intervals);
    Image8 best;
    int best_index = 0;
    double sharpest = -1;
    for (; next < end; ++next) {
      Image8 frame = reader.ReadFrame(next);
      const double sharpness = Sharpness(frame);
      if (sharpness > sharpest) {
        sharpest = sharpness;
        best = std::move(frame);
        best_index = next;
      }
      progress(next + 1, total);
    }
    char name[32];
    std::snprintf(name, sizeof name, "frame_%06d.jpg", best_index);
    WriteImage(folder + "/" + name, best);
    names.push_back(name);
  }
  return names;
}

}  // namespace cosplat

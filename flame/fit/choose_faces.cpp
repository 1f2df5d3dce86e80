#include "flame/fit/choose_faces.h"

#include <algorithm>
#include <cmath>

#include "flame/io/landmarks.h"

namespace cosplat {
namespace {

// The furthest that one face moves between neighbouring frames, in units of its size, and the
// largest ratio of its sizes. What exceeds them is a cut, or another face.
constexpr double kMaxStep = 0.5, kMaxGrowth = 1.5;
// Frames without a face after which the same face need not be found again.
constexpr int kMaxGap = 12;
// Frames that are further apart than this, and not neighbours, do not follow each other.
constexpr double kMaxStepSeconds = 0.05;

bool SameFace(const FaceBox& a, const FaceBox& b) {
  const auto [ax, ay] = a.middle();
  const auto [bx, by] = b.middle();
  const double larger = std::max(a.size(), b.size()), smaller = std::min(a.size(), b.size());
  return std::hypot(ax - bx, ay - by) <= kMaxStep * larger && larger <= kMaxGrowth * smaller;
}

double Distance(const DetectedFace& face, int i, int k) {
  return std::hypot(face.points[i][0] - face.points[k][0], face.points[i][1] - face.points[k][1]);
}

// How far an eye is open, from its lids' distance relative to its width: the iris is seen from 1
// on, and guessed at 0.
double Openness(const DetectedFace& face, int upper, int lower, int inner, int outer) {
  constexpr double kClosed = 0.12, kOpen = 0.2;
  const double width = Distance(face, inner, outer);
  const double ratio = width > 0 ? Distance(face, upper, lower) / width : 0;
  return std::clamp((ratio - kClosed) / (kOpen - kClosed), 0.0, 1.0);
}

// MediaPipe numbers the points of both eyes, then of the irises: five of each from these on.
constexpr int kRightIris = 468, kLeftIris = 473, kIrisPoints = 5;

std::vector<double> WeightsOf(const DetectedFace& face, LandmarkSet set) {
  std::vector<double> weights(face.points.size(), 1);
  if (set != LandmarkSet::kMediapipe478) return weights;
  std::fill_n(&weights[kRightIris], kIrisPoints, Openness(face, 159, 145, 133, 33));
  std::fill_n(&weights[kLeftIris], kIrisPoints, Openness(face, 386, 374, 362, 263));
  return weights;
}

// The face of `frame` that is `last`, else the largest; null if there is none.
const DetectedFace* Choose(const LandmarkFrame& frame, const FaceBox* last, bool& follows) {
  const DetectedFace* chosen = nullptr;
  follows = false;
  for (const DetectedFace& face : frame.faces) {
    const bool same = last && SameFace(*last, BoxOf(face.points));
    const bool larger = !chosen || BoxOf(face.points).size() > BoxOf(chosen->points).size();
    if ((same && !follows) || (same == follows && larger)) chosen = &face;
    follows = follows || same;
  }
  return chosen;
}

}  // namespace

ChosenFaces ChooseFaces(const LandmarkVideo& video) {
  ChosenFaces chosen;
  std::optional<FaceBox> last;
  int gap = 0, last_frame = 0;
  size_t found = 0;
  const double rate = video.rate();
  for (const LandmarkFrame& frame : video.frames) {
    bool follows;
    const DetectedFace* face = Choose(frame, last ? &*last : nullptr, follows);
    if (!face) {
      chosen.faces.push_back(std::nullopt);
      chosen.skipped.push_back({frame.name, "has no face"});
      if (++gap > kMaxGap) last.reset();
      continue;
    }
    const int step = frame.frame - last_frame;
    const bool just_before = step == 1 || step <= kMaxStepSeconds * rate;
    chosen.cuts += last && !follows && (just_before || gap > 0);
    const FaceBox box = BoxOf(face->points);
    chosen.faces.push_back(ObservedFace{face->points,
                                        WeightsOf(*face, video.set),
                                        box.size(),
                                        follows && gap == 0 && just_before,
                                        frame.frame / rate});
    last = box;
    last_frame = frame.frame;
    gap = 0;
    ++found;
  }
  CheckSkipped(video.file, found, chosen.skipped);
  return chosen;
}

}  // namespace cosplat

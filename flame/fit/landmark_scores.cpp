#include "flame/fit/landmark_scores.h"

#include <algorithm>
#include <cmath>

namespace cosplat {
namespace {

// The score of a length that is 0 up to `from` and 1 from `to` on; either may be the larger one.
float Ramp(double x, double from, double to) {
  return float(std::clamp((x - from) / (to - from), 0.0, 1.0));
}

// Landmarks in the frame of the face.
class FaceFrame {
 public:
  explicit FaceFrame(const DetectedFace& face) : face_(face) {
    constexpr size_t kRightCorner = 33, kLeftCorner = 263;
    const auto &right = face.points[kRightCorner], &left = face.points[kLeftCorner];
    x_ = left[0] - right[0], y_ = left[1] - right[1];
  }
  bool usable() const { return x_ * x_ + y_ * y_ > 1; }  // px
  std::array<double, 2> At(size_t point) const {
    constexpr size_t kBridge = 168;
    const double dx = face_.points[point][0] - face_.points[kBridge][0];
    const double dy = face_.points[point][1] - face_.points[kBridge][1];
    const double squared = x_ * x_ + y_ * y_;
    return {(x_ * dx + y_ * dy) / squared, (x_ * dy - y_ * dx) / squared};
  }
  double Distance(size_t a, size_t b) const {
    return std::hypot(At(a)[0] - At(b)[0], At(a)[1] - At(b)[1]);
  }

 private:
  const DetectedFace& face_;
  double x_, y_;  // from the right eye's outer corner to the left one's, px
};

struct Side {
  const char* name;
  double outwards;  // along x
  size_t outer, inner, upper_lid, lower_lid, iris, mouth_corner, brow;
};
constexpr Side kSides[] = {{"Right", -1, 33, 133, 159, 145, 468, 61, 52},
                           {"Left", 1, 263, 362, 386, 374, 473, 291, 282}};

void ScoreEye(const FaceFrame& frame,
              const Side& s,
              bool irises,
              std::map<std::string, float>& to) {
  const double width = std::max(frame.Distance(s.outer, s.inner), 1e-6);
  const double gap = frame.Distance(s.upper_lid, s.lower_lid) / width;
  to[std::string("eyeBlink") + s.name] = Ramp(gap, 0.35, 0);
  to[std::string("eyeWide") + s.name] = Ramp(gap, 0.3, 0.5);
  if (!irises) return;
  const auto outer = frame.At(s.outer), inner = frame.At(s.inner), iris = frame.At(s.iris);
  const double out = s.outwards * (iris[0] - (outer[0] + inner[0]) / 2) / width;
  const double down = (iris[1] - (outer[1] + inner[1]) / 2) / width;
  to[std::string("eyeLookOut") + s.name] = Ramp(out, 0, 0.25);
  to[std::string("eyeLookIn") + s.name] = Ramp(-out, 0, 0.25);
  to[std::string("eyeLookDown") + s.name] = Ramp(down, 0, 0.15);
  to[std::string("eyeLookUp") + s.name] = Ramp(-down, 0, 0.15);
}

void ScoreMouth(const FaceFrame& frame, std::map<std::string, float>& to) {
  constexpr size_t kUpperLip = 13, kLowerLip = 14, kUpperRim = 0, kLowerRim = 17, kNose = 2;
  constexpr size_t kForehead = 10, kChin = 152;
  const double height = std::max(frame.Distance(kForehead, kChin), 1e-6);
  to["jawOpen"] = Ramp(frame.Distance(kUpperLip, kLowerLip) / height, 0, 0.18);
  to["mouthPucker"] =
      Ramp(frame.Distance(kSides[0].mouth_corner, kSides[1].mouth_corner), 0.62, 0.42);
  to["mouthFunnel"] = Ramp(frame.Distance(kUpperRim, kLowerRim), 0.18, 0.78);
  const double lips = (frame.At(kUpperLip)[1] + frame.At(kLowerLip)[1]) / 2;
  const double raised = frame.At(kUpperLip)[1] - frame.At(kNose)[1];
  for (const Side& s : kSides) {
    const auto corner = frame.At(s.mouth_corner);
    to[std::string("mouthSmile") + s.name] = Ramp(std::abs(corner[0]), 0.25, 0.45);
    to[std::string("mouthFrown") + s.name] = Ramp(corner[1] - lips, 0, 0.15);
    to[std::string("mouthUpperUp") + s.name] = Ramp(raised, 0.3, 0);
  }
}

void ScoreBrows(const FaceFrame& frame, std::map<std::string, float>& to) {
  constexpr size_t kInnerBrow[] = {55, 285};
  double inner = 0;
  for (int i = 0; i < 2; ++i) {
    const double lid = frame.At(kSides[i].upper_lid)[1];
    inner += (lid - frame.At(kInnerBrow[i])[1]) / 2;
    to[std::string("browOuterUp") + kSides[i].name] =
        Ramp(lid - frame.At(kSides[i].brow)[1], 0.12, 0.52);
  }
  to["browInnerUp"] = Ramp(inner, 0.09, 0.39);
}

}  // namespace

std::map<std::string, float> ScoresOf(const DetectedFace& face, LandmarkSet set) {
  const bool irises = set == LandmarkSet::kMediapipe478;
  if (!irises && set != LandmarkSet::kMediapipe468) return {};
  const FaceFrame frame(face);
  if (!frame.usable()) return {};
  std::map<std::string, float> scores;
  for (const Side& side : kSides) ScoreEye(frame, side, irises, scores);
  ScoreMouth(frame, scores);
  ScoreBrows(frame, scores);
  return scores;
}

void AddScores(LandmarkVideo& video) {
  for (LandmarkFrame& frame : video.frames)
    for (DetectedFace& face : frame.faces)
      if (face.blendshapes.empty()) face.blendshapes = ScoresOf(face, video.set);
}

}  // namespace cosplat

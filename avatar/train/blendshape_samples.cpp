#include "avatar/train/blendshape_samples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "avatar/model/blendshape_map.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using Pixel = std::array<double, 2>;

// The head's centre is off the face's by less than the face's size, however it is turned.
constexpr double kMaxFromFace = 1;

double Distance(const Pixel& a, const Pixel& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

// The tracked head's centre, in px of the landmarks' images.
Pixel HeadCenter(const TrackedFrame& frame,
                 const LandmarkVideo& landmarks,
                 const FlamePoser<float>& poser,
                 std::vector<float>& vertices) {
  auto parameters = FlamePoser<float>::ParametersOf(frame.params);
  parameters.expression.clear();
  poser.Forward(parameters, vertices);
  std::array<double, 3> mean{}, seen{};
  for (size_t i = 0; i < vertices.size(); ++i)
    mean[i % 3] += 3 * double(vertices[i]) / vertices.size();
  const Camera& camera = frame.camera;
  for (size_t r = 0; r < 3; ++r) {
    seen[r] = camera.translation[r];
    for (size_t k = 0; k < 3; ++k) seen[r] += camera.rotation[3 * r + k] * mean[k];
  }
  return {(camera.fx * seen[0] / seen[2] + camera.cx) * landmarks.width / camera.width,
          (camera.fy * seen[1] / seen[2] + camera.cy) * landmarks.height / camera.height};
}

void CheckProportions(const LandmarkVideo& landmarks, const Camera& camera) {
  const double width = double(camera.width) * landmarks.height / camera.height;
  // Images at 1/r of their size are rounded to whole pixels.
  const double tolerance = 1 + double(landmarks.height) / camera.height;
  if (std::abs(width - landmarks.width) > tolerance)
    throw Error(landmarks.file,
                "width, height",
                "are " + SizeText(landmarks.width, landmarks.height) +
                    ", but the tracked video has images of " +
                    SizeText(camera.width, camera.height) + ": they are of another video");
}

std::string Shown(const std::string& name) { return "'" + name + "'"; }

class ScoreMatcher {
 public:
  ScoreMatcher(const LandmarkVideo& landmarks, const FlamePoser<float>& poser)
      : landmarks_(landmarks), poser_(poser) {
    for (const LandmarkFrame& frame : landmarks.frames) by_name_.emplace(frame.name, &frame);
  }

  BlendshapeSamples Match(const std::vector<TrackedFrame>& frames) {
    if (!frames.empty()) CheckProportions(landmarks_, frames[0].camera);
    BlendshapeSamples samples;
    std::vector<const DetectedFace*> faces;
    for (size_t i = 0; i < frames.size(); ++i) {
      const DetectedFace* face = FaceIn(frames[i]);
      if (!face) continue;
      faces.push_back(face);
      samples.faces.push_back(frames[i].params);
      samples.frames.push_back(i);
    }
    CheckMatches(frames);
    AddScores(faces, samples);
    return samples;
  }

 private:
  // The scored face nearest to the tracked head; null if there is none on it.
  const DetectedFace* FaceIn(const TrackedFrame& frame) {
    const auto found = by_name_.find(frame.name);
    if (found == by_name_.end()) return nullptr;
    ++named_;
    const DetectedFace* nearest = nullptr;
    FaceBox box{};
    Pixel head{};
    for (const DetectedFace& face : found->second->faces) {
      if (face.blendshapes.empty()) continue;
      if (!nearest) head = HeadCenter(frame, landmarks_, poser_, vertices_);
      const FaceBox candidate = BoxOf(face.points);
      if (nearest && Distance(candidate.middle(), head) >= Distance(box.middle(), head)) continue;
      nearest = &face;
      box = candidate;
    }
    if (!nearest) return nullptr;
    ++scored_;
    if (Distance(box.middle(), head) <= kMaxFromFace * std::max(box.width(), box.height()))
      return nearest;
    ++elsewhere_;
    return nullptr;
  }

  void CheckMatches(const std::vector<TrackedFrame>& frames) const {
    if (frames.empty()) return;
    if (named_ == 0)
      throw Error(landmarks_.file,
                  "frames",
                  "none is of this video: the first is " +
                      (landmarks_.frames.empty() ? "absent" : Shown(landmarks_.frames[0].name)) +
                      ", the video's " + Shown(frames[0].name));
    if (2 * elsewhere_ > scored_)
      throw Error(landmarks_.file,
                  "frames",
                  std::to_string(elsewhere_) + " of " + std::to_string(scored_) +
                      " faces are not where the tracked head is: they are of another video");
  }

  static void AddScores(const std::vector<const DetectedFace*>& faces, BlendshapeSamples& samples) {
    std::vector<BlendshapeScores> scores;
    std::set<std::string> names;
    for (const DetectedFace* face : faces) {
      scores.emplace_back();
      for (const auto& [name, score] : face->blendshapes) {
        scores.back()[ArkitSpelling(name)] = score;
        names.insert(ArkitSpelling(name));
      }
    }
    samples.names.assign(names.begin(), names.end());
    for (const BlendshapeScores& of_frame : scores) {
      std::vector<float>& row = samples.scores.emplace_back();
      for (const std::string& name : names) {
        const auto score = of_frame.find(name);
        row.push_back(score == of_frame.end() ? 0.0f : score->second);
      }
    }
  }

  const LandmarkVideo& landmarks_;
  const FlamePoser<float>& poser_;
  std::map<std::string, const LandmarkFrame*> by_name_;
  std::vector<float> vertices_;
  size_t named_ = 0, scored_ = 0, elsewhere_ = 0;  // frames
};

}  // namespace

BlendshapeSamples MatchScores(const LandmarkVideo& landmarks,
                              const std::vector<TrackedFrame>& frames,
                              const FlamePoser<float>& poser) {
  return ScoreMatcher(landmarks, poser).Match(frames);
}

}  // namespace cosplat

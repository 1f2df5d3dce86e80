#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/cosplat/run/track_run.h"
#include "avatar/surface/silhouette.h"
#include "flame/pose.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Less than this is too little.
constexpr double kMinTurn = 25, kMinNod = 20;      // degrees: to each side, in all
constexpr double kMinBlink = 0.5, kMinOpen = 0.4;  // the highest score in the video
constexpr double kMinSmile = 0.35;                 // between the lowest and the highest
constexpr size_t kMinFrames = 150;
constexpr double kMinFace = 120;      // px of the whole frame
constexpr double kBlurred = 0.4;      // of the median sharpness
constexpr double kManyFrames = 0.05;  // of all
constexpr double kOutermost = 0.02;   // of the frames, which may be mistaken

struct Span {
  double low, high;
};

Span SpanOf(std::vector<double> values, double outermost) {
  std::sort(values.begin(), values.end());
  const size_t skipped = size_t(outermost * double(values.size() - 1));
  return {values[skipped], values[values.size() - 1 - skipped]};
}

double Degrees(double radians) { return radians * 180 / std::numbers::pi; }

void AdviseTurns(const TrackRun& run, std::vector<std::string>& advice) {
  std::vector<double> turns, nods;
  for (const size_t f : run.kept) {
    // The camera looks along -z: a full face looks along z, its own left is the image's right.
    const math::Vec3<float> forward = HeadForward(run.fit.frames[f]->params);
    turns.push_back(Degrees(std::atan2(forward.x, forward.z)));
    nods.push_back(Degrees(std::asin(std::clamp(forward.y, -1.0f, 1.0f))));
  }
  const Span turn = SpanOf(turns, kOutermost), nod = SpanOf(nods, kOutermost);
  const double left = std::max(0.0, turn.high), right = std::max(0.0, -turn.low);
  if (std::min(left, right) < kMinTurn)
    advice.push_back(
        Format("The head turns by {:.0f} degrees to its left and {:.0f} to its right. What lies "
               "beyond is guessed: turn it slowly by some 45 degrees to both sides.",
               left,
               right));
  if (nod.high - nod.low < kMinNod)
    advice.push_back(Format("The head nods by {:.0f} degrees in all: look up and down, too.",
                            nod.high - nod.low));
}

// What only the head moves, without hair, in the image that trains: a frame's square may end within
// the frame.
bool IsCutOff(const FlamePoser<float>& poser, const FlameParams& params, const Camera& camera) {
  constexpr float kBody = 0.01f;  // the root's share
  std::vector<float> vertices;
  poser.Forward(FlamePoser<float>::ParametersOf(params), vertices);
  for (size_t v = 0; v < size_t(poser.model().own_vertex_count()); ++v) {
    if (poser.model().skinning_weights[kFlameJoints * v] > kBody) continue;
    const ImagePoint p =
        Project(camera, {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]});
    if (p.x < 0 || p.y < 0 || p.x > float(camera.width) || p.y > float(camera.height)) return true;
  }
  return false;
}

void AdviseRoom(const TrackRun& run, std::vector<std::string>& advice) {
  const FlamePoser<float> poser(run.model, run.fit.shape);
  const auto cut = size_t(std::count_if(run.kept.begin(), run.kept.end(), [&](size_t f) {
    return IsCutOff(poser, run.fit.frames[f]->params, run.fit.camera);
  }));
  if (double(cut) > kManyFrames * double(run.kept.size()))
    advice.push_back(Format("The image cuts the head off in {} of {} frames: leave room around it.",
                            cut,
                            run.kept.size()));
}

void AdviseLooks(const TrackRun& run,
                 const std::vector<size_t>& other_looks,
                 std::vector<std::string>& advice) {
  constexpr size_t kNamed = 3;
  if (other_looks.empty()) return;
  std::string frames;
  for (size_t i = 0; i < std::min(kNamed, other_looks.size()); ++i)
    frames += (i > 0 ? ", " : "") + run.marks.frames[run.kept[other_looks[i]]].name;
  if (other_looks.size() > kNamed) frames += Format(" and {} more", other_looks.size() - kNamed);
  advice.push_back(
      Format("From frame {} on the face looks different: is it another person, shot or light? An "
             "avatar is of one: leave the others out.",
             frames));
}

// The scores of the faces that were fitted; false if they have none of these.
bool ScoresOf(const TrackRun& run,
              const std::vector<std::string>& names,
              bool lowest,
              std::vector<double>& scores) {
  for (const size_t f : run.kept) {
    const auto& faces = run.marks.frames[f].faces;
    const auto face = std::find_if(faces.begin(), faces.end(), [&](const DetectedFace& seen) {
      return seen.points == run.chosen.faces[f]->points;
    });
    double score = lowest ? 1 : 0;
    for (const std::string& name : names) {
      const auto found = face->blendshapes.find(name);
      if (found == face->blendshapes.end()) return false;
      score =
          lowest ? std::min(score, double(found->second)) : std::max(score, double(found->second));
    }
    scores.push_back(score);
  }
  return true;
}

void AdviseExpressions(const TrackRun& run, std::vector<std::string>& advice) {
  std::vector<double> blinks, open, smiles;
  if (ScoresOf(run, {"eyeBlinkLeft", "eyeBlinkRight"}, true, blinks) &&
      SpanOf(blinks, 0).high < kMinBlink)
    advice.push_back("No frame shows closed eyes: blink slowly, some times.");
  if (ScoresOf(run, {"jawOpen"}, false, open) && SpanOf(open, 0).high < kMinOpen)
    advice.push_back("The mouth is never wide open: open it, and show teeth.");
  if (!ScoresOf(run, {"mouthSmileLeft", "mouthSmileRight"}, true, smiles)) return;
  const Span smile = SpanOf(smiles, kOutermost);
  if (smile.high - smile.low < kMinSmile)
    advice.push_back("There is no broad smile beside a face at rest: show both.");
}

void AdviseFrames(const TrackRun& run,
                  const std::vector<double>& sharpness,
                  std::vector<std::string>& advice) {
  const size_t kept = run.kept.size(), all = run.fit.frames.size();
  if (kept < kMinFrames)
    advice.push_back(Format("There are {} frames: 20 seconds or more show more of a face.", kept));
  std::vector<double> sizes;
  const double scale = run.marks.crop ? run.marks.crop->scale_x() : 1;
  for (const size_t f : run.kept) sizes.push_back(run.chosen.faces[f]->size / scale);
  const double size = SpanOf(sizes, 0.5).low;
  if (size < kMinFace)
    advice.push_back(
        Format("The face is {:.0f} pixels wide in the video: film from nearer, or in a higher "
               "resolution.",
               size));
  const double least = kBlurred * SpanOf(sharpness, 0.5).low;
  const auto blurred = size_t(std::count_if(
      sharpness.begin(), sharpness.end(), [&](double value) { return value < least; }));
  if (double(blurred) > kManyFrames * double(kept))
    advice.push_back(
        Format("{} of {} frames are blurred: more light makes exposures shorter.", blurred, kept));
  if (double(all - kept) > kManyFrames * double(all))
    advice.push_back(
        Format("{} of {} frames are left out, for the reasons listed below.", all - kept, all));
  if (run.chosen.cuts > 0)
    advice.push_back(Format("There are {} cuts, or jumps: film in one go.", run.chosen.cuts));
}

}  // namespace

std::vector<std::string> AdviceFor(const TrackRun& run,
                                   const std::vector<double>& sharpness,
                                   const std::vector<size_t>& other_looks) {
  std::vector<std::string> advice;
  AdviseRoom(run, advice);
  AdviseLooks(run, other_looks, advice);
  AdviseTurns(run, advice);
  AdviseExpressions(run, advice);
  AdviseFrames(run, sharpness, advice);
  return advice;
}

}  // namespace cosplat

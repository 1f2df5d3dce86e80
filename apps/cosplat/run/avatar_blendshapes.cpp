#include "apps/cosplat/run/avatar_blendshapes.h"

#include <cstdio>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

std::string ToString(const BlendshapeFitFigures& figures) {
  return Format("R2 {:.2f}, {:.2f} mm ({:.2f} mm for the mean face)",
                figures.r2,
                1e3 * figures.error,
                1e3 * figures.mean_face_error);
}

Json ToJson(const BlendshapeFitFigures& figures) {
  return {{"frames", figures.frames},
          {"R2", figures.r2},
          {"error_mm", 1e3 * figures.error},
          {"mean_face_error_mm", 1e3 * figures.mean_face_error}};
}

}  // namespace

AvatarBlendshapes::AvatarBlendshapes(const std::string& landmarks,
                                     const FlameModel& flame,
                                     const AvatarSubject& subject)
    : landmarks_(landmarks),
      subject_(subject),
      poser_(flame, subject.video().shape, subject.video().static_offset) {
  if (landmarks.empty()) return;
  const LandmarkVideo video = ReadLandmarks(landmarks);
  train_ = MatchScores(video, subject.video().train, poser_);
  test_ = MatchScores(video, subject.video().test, poser_);
}

void AvatarBlendshapes::Fit(AvatarModel& avatar) {
  if (landmarks_.empty()) return;
  const std::vector<FlameParams> track = subject_.RefinedTrack();
  for (size_t i = 0; i < train_.size(); ++i) train_.faces[i] = track[train_.frames[i]];
  try {
    fit_ = FitBlendshapes(poser_, train_);
  } catch (const Error& error) {
    problem_ = error.what();
    return;
  }
  if (fit_->map.fit.r2 <= 0) {
    problem_ = "held out in turn, frames are predicted no better than by the mean face (" +
               ToString(fit_->map.fit) + ")";
    fit_.reset();
    return;
  }
  on_test_ = MeasureBlendshapes(poser_, *fit_, test_);
  avatar.blendshapes = fit_->map;
}

std::string AvatarBlendshapes::Summary() const {
  if (!fit_ && problem_.empty()) return "";  // no file, or nothing was saved
  if (!fit_) return landmarks_ + ": no blendshape map: " + problem_ + "\n";
  std::string line = "blendshape map: " + std::to_string(fit_->varying) + " scores that vary, " +
                     std::to_string(train_.size()) +
                     " frames; held out in turn: " + ToString(fit_->map.fit);
  if (on_test_.frames > 0)
    line += "; " + std::to_string(on_test_.frames) + " test frames: " + ToString(on_test_);
  return line + "\n";
}

void AvatarBlendshapes::Write(const std::string& folder) const {
  const std::string path = folder + "/blendshapes.json";
  std::error_code ignored;
  if (!fit_) return void(std::filesystem::remove(path, ignored));
  Json json{{"landmarks", landmarks_},
            {"scores", fit_->map.names},
            {"varying", fit_->varying},
            {"ridge", fit_->strength},
            {"held_out", ToJson(fit_->map.fit)}};
  if (on_test_.frames > 0) json["test"] = ToJson(on_test_);
  WriteFileAtomically(path, json.dump(2) + "\n");
}

}  // namespace cosplat

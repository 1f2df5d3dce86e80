#include "apps/viewer/session.h"

#include <algorithm>
#include <cmath>

#include "avatar/math/turn.h"

namespace cosplat::viewer {
namespace {

FaceControls ControlsOf(const Content& content) {
  if (!content.avatar) return {};
  const Content::Avatar& avatar = *content.avatar;
  return {avatar.flame.expression_count, avatar.rest, avatar.model.trained_range};
}

int MaxPerFace(const Content& content) {
  if (!content.avatar) return 0;
  const AvatarModel& model = content.avatar->model;
  const std::vector<int> counts = CountPerFace(model.embedding.triangle, model.mesh.faces.size());
  return *std::max_element(counts.begin(), counts.end());
}

}  // namespace

Session::Session(const Content& content)
    : camera(content.start),
      face(ControlsOf(content)),
      background(content.background),
      title_(content.title),
      is_avatar_(content.avatar.has_value()),
      gaussian_count_(content.gaussian_count()),
      max_per_face_(MaxPerFace(content)),
      filmed_(content.avatar ? content.avatar->model.filmed : std::nullopt),
      center_(math::ToVec3(content.start.center)) {}

void Session::SetSequence(std::vector<FlameParams> faces, double frames_per_second) {
  sequence_ = std::move(faces);
  timeline = Timeline(int(sequence_.size()), frames_per_second);
  timeline.Play();
  driver = Driver::kSequence;
}

void Session::SetLive(std::unique_ptr<LiveFace> live) {
  if (!live) TakeSliders();
  live_ = std::move(live);
  if (live_) driver = Driver::kLive;
}

void Session::Advance(int64_t now_ns) {
  const int64_t passed = advanced_ ? now_ns - now_ns_ : 0;
  now_ns_ = now_ns;
  advanced_ = true;
  if (driver == Driver::kSequence) timeline.Advance(1e-9 * double(passed));
  if (live_) live_->Advance(now_ns);
}

void Session::TakeSliders() {
  if (driver == Driver::kSliders) return;
  face.SetFace(Face());
  timeline.Pause();
  driver = Driver::kSliders;
}

void Session::SetView(View view) {
  if (is_avatar_ || !NeedsMesh(view)) view_ = view;
}

void Session::DoToSequence(Action action) {
  if (!has_sequence()) return;
  driver = Driver::kSequence;
  if (action == Action::kTogglePlay) timeline.Toggle();
  if (action == Action::kStepBack) timeline.Step(-1);
  if (action == Action::kStepForward) timeline.Step(1);
  if (action == Action::kToStart) timeline.Seek(0);
}

void Session::Do(Action action) {
  switch (action) {
    case Action::kTogglePlay:
    case Action::kStepBack:
    case Action::kStepForward:
    case Action::kToStart:
      return DoToSequence(action);
    case Action::kToggleLoop:
      timeline.loops = !timeline.loops;
      return;
    case Action::kResetView:
      return camera.Reset();
    case Action::kNeutralFace:
      TakeSliders();
      return face.SetNeutral();
    case Action::kRandomFace:
      TakeSliders();
      return face.SetRandom(random_);
    case Action::kCalibrate:
      if (live_) live_->Calibrate();
      return;
    case Action::kViewSplats:
    case Action::kViewEllipsoids:
    case Action::kViewTriangles:
    case Action::kViewWire:
      return SetView(View(int(action) - int(Action::kViewSplats)));
    case Action::kToggleTransparent:
      transparent = !transparent;
      return;
    case Action::kTogglePanels:
      panels_open = !panels_open;
      return;
    case Action::kToggleHelp:
      help_open = !help_open;
      return;
    default:  // handled by the window
      return;
  }
}

FlameParams Session::Face() const {
  if (driver == Driver::kSequence) return sequence_[size_t(timeline.frame())];
  if (driver == Driver::kLive) return live_->Face();
  return face.Face();
}

Shot Session::ShotFor(int width, int height) const {
  Shot shot;
  shot.view = view_;
  if (is_avatar_) shot.face = Face();
  shot.camera = camera.At(width, height);
  shot.background = background;
  shot.transparent = transparent;
  return shot;
}

bool Session::IsBeyondFilm() const {
  return filmed_ &&
         cosplat::IsBeyondFilm(*filmed_, Face(), center_, math::ToVec3(camera.At(1, 1).Center()));
}

int64_t Session::input_ns() const { return driver == Driver::kLive ? live_->input_ns() : now_ns_; }

}  // namespace cosplat::viewer

// State of the viewer: the camera position, what drives the face, what is drawn.
//
// Keys, mouse and panels change it; Advance moves it on in time; ShotFor returns what to draw. It
// is independent of the window, so that tests and `--headless` drive it as the window does.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/face_controls.h"
#include "apps/viewer/live_face.h"
#include "apps/viewer/orbit_camera.h"
#include "apps/viewer/stage.h"
#include "apps/viewer/timeline.h"

namespace cosplat::viewer {

enum class Driver { kSliders, kSequence, kLive };

enum class Action {
  kTogglePlay,
  kStepBack,
  kStepForward,
  kToStart,
  kToggleLoop,
  kResetView,
  kNeutralFace,
  kRandomFace,
  kCalibrate,
  kViewSplats,
  kViewEllipsoids,
  kViewTriangles,
  kViewWire,
  kToggleTransparent,
  kTogglePanels,
  kToggleHelp,
  kToggleDrive,  // this and the following are handled by the window
  kScreenshot,
  kToggleRecording,
  kQuit
};

class Session {
 public:
  explicit Session(const Content& content);

  // Sets the faces of a recorded sequence (at least one), which drives from now on and plays from
  // its start.
  void SetSequence(std::vector<FlameParams> faces, double frames_per_second);
  // The live face drives from now on. Null: there is none any more, and the sliders do.
  void SetLive(std::unique_ptr<LiveFace> live);

  // Advances to the time `now_ns` of any monotonic clock.
  void Advance(int64_t now_ns);
  // Does nothing if the action does not apply or is the window's.
  void Do(Action action);
  // Makes the sliders drive the face, starting from its current state.
  void TakeSliders();
  // Ignored if the content does not have this view.
  void SetView(View view);

  Shot ShotFor(int width, int height) const;
  FlameParams Face() const;
  // Time of the input that ShotFor shows: the frame's own time for live input, otherwise that of
  // Advance.
  int64_t input_ns() const;
  // Whether the camera sees an avatar's head from beyond where its training frames did, by more
  // than twelve degrees: what it shows there is a guess. False where the file does not say.
  bool IsBeyondFilm() const;

  bool is_avatar() const { return is_avatar_; }
  bool has_sequence() const { return !sequence_.empty(); }
  LiveFace* live() const { return live_.get(); }
  const std::string& title() const { return title_; }
  size_t gaussian_count() const { return gaussian_count_; }
  int max_per_face() const { return max_per_face_; }  // most Gaussians on one triangle
  View view() const { return view_; }

  // Freely modified by mouse and panels.
  OrbitCamera camera;
  FaceControls face;
  Timeline timeline;
  Driver driver = Driver::kSliders;
  std::array<float, 3> background;  // sRGB
  bool transparent = false;
  bool panels_open = true;
  bool help_open = false;
  std::string drive;  // as it stands in the panel
  // Opens a drive of avatar/live/source.h and the like, and lets it drive; throws Error. Null: none
  // can be chosen.
  std::function<void(Session&, const std::string& drive)> open_drive;

 private:
  void DoToSequence(Action action);

  std::string title_;
  bool is_avatar_;
  size_t gaussian_count_;
  int max_per_face_ = 0;
  std::optional<FilmedFrom> filmed_;
  math::Vec3<float> center_;  // of the head
  View view_ = View::kSplats;
  std::vector<FlameParams> sequence_;
  std::unique_ptr<LiveFace> live_;
  Rng random_;
  int64_t now_ns_ = 0;
  bool advanced_ = false;
};

}  // namespace cosplat::viewer

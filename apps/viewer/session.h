// What the viewer is at a moment: where the camera stands, what drives the face, what is drawn.
//
// Keys, mouse and panels change it; Advance moves it on in time; ShotFor says what to draw. Knows
// no window, so that tests and `--headless` drive it as the window does.
#pragma once

#include <cstdint>
#include <memory>
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
  kViewSplats,
  kViewEllipsoids,
  kViewTriangles,
  kViewWire,
  kToggleTransparent,
  kTogglePanels,
  kToggleHelp,
  kScreenshot,  // this and the following are of the window
  kToggleRecording,
  kQuit
};

class Session {
 public:
  explicit Session(const Content& content);

  // A recorded sequence's faces, one at least; drives from now on, from its beginning, and plays.
  void SetSequence(const std::string& name,
                   std::vector<FlameParams> faces,
                   double frames_per_second);
  // Drives from now on.
  void SetLive(std::unique_ptr<LiveFace> live);

  // To the time `now_ns` of any clock that does not run backwards.
  void Advance(int64_t now_ns);
  // Does nothing where there is nothing to do it to, or it is the window's.
  void Do(Action action);
  // The sliders take over where they are not what drives: the face stays as it is.
  void TakeSliders();
  // Nothing for a view that this content has not.
  void SetView(View view);

  Shot ShotFor(int width, int height) const;
  FlameParams Face() const;
  // When what ShotFor returns came in: of live input its frame's time, else that of Advance.
  int64_t input_ns() const;

  bool is_avatar() const { return is_avatar_; }
  bool has_sequence() const { return !sequence_.empty(); }
  LiveFace* live() const { return live_.get(); }
  const std::string& title() const { return title_; }
  const std::string& sequence_name() const { return sequence_name_; }
  size_t gaussian_count() const { return gaussian_count_; }
  int most_per_face() const { return most_per_face_; }  // Gaussians on one triangle
  View view() const { return view_; }

  // The mouse and the panels set these as they like.
  OrbitCamera camera;
  FaceControls face;
  Timeline timeline;
  Driver driver = Driver::kSliders;
  std::array<float, 3> background;  // sRGB
  bool transparent = false;
  bool panels_open = true;
  bool help_open = false;

 private:
  void DoToSequence(Action action);

  std::string title_, sequence_name_;
  bool is_avatar_;
  size_t gaussian_count_;
  int most_per_face_ = 0;
  View view_ = View::kSplats;
  std::vector<FlameParams> sequence_;
  std::unique_ptr<LiveFace> live_;
  Rng random_;
  int64_t now_ns_ = 0;
  bool advanced_ = false;
};

}  // namespace cosplat::viewer

// A face that a camera sees, as the frames that move an avatar.
//
// apps/landmarks/camera.mjs -> a line -> ParseCameraFrame -> CameraFace -> JsonFrame -> who shows
// it.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "avatar/live/json_frame.h"
#include "avatar/live/smoother.h"

namespace cosplat {

// What camera.mjs says of one frame.
struct CameraFrame {
  std::string camera;         // its name
  int width = 0, height = 0;  // px
  double seconds = 0;         // when it was captured, by the camera's clock
  double milliseconds = 0;    // that finding the face took
  int bar = -1;               // the number in the bar of a LatencyFilm; -1: there is none
  // MediaPipe's 478 points, px: x right, y down, z away from the camera, in the scale of x. Empty:
  // there is no face.
  std::vector<std::array<double, 3>> points;
};

// Throws Error naming the field if the line is no frame.
CameraFrame ParseCameraFrame(const std::string& line);

// Scores of the blendshapes (flame/fit/landmark_scores.h), and the head's turn and place beside a
// neutral face: that of the first kNeutralFrames frames, or after Calibrate of the next ones.
class CameraFace {
 public:
  static constexpr int kNeutralFrames = 15;

  CameraFace();
  // None while there is no face, or the neutral one is being seen. Turns are about FLAME's axes,
  // radians; the translation, in metres, is what the turn about the neck does not explain, by the
  // distance of the eyes' corners and a field of view of 63 degrees, as MediaPipe assumes.
  std::optional<JsonFrame> Next(const CameraFrame& frame);
  void Calibrate() { neutral_frames_ = 0; }
  bool IsCalibrated() const { return neutral_frames_ >= kNeutralFrames; }

 private:
  struct Head {
    std::vector<std::array<double, 3>> points;  // that no expression moves; FLAME's axes, px
    double eyes = 0;                            // px between the outer corners
  };

  static Head HeadIn(const CameraFrame& frame);
  void AddNeutral(const Head& head);
  FlameParams MotionOf(const Head& head, const CameraFrame& frame) const;

  Head neutral_;  // sums until it is calibrated
  int neutral_frames_ = 0, width_ = 0, height_ = 0;
  FaceSmoother smoother_;
  std::optional<double> last_;  // seconds of the frame before
  uint64_t sequence_ = 0;
};

}  // namespace cosplat

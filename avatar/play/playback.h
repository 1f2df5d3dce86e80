// Plays a sequence with consecutive frames in a pipeline: while one frame is rendered, the next is
// posed and bound.
//
// PlaybackFrame n -> Playback::Next -> image n - 1. One frame of latency; images are returned in
// order and are bit-identical to those of Player::RenderOver, for any number of threads.
#pragma once

#include <array>
#include <exception>
#include <optional>

#include "avatar/play/player.h"

namespace cosplat {

struct PlaybackFrame {
  FlameParams params;
  Camera camera;
  std::array<float, 3> background{0, 0, 0};  // sRGB
};

class Playback {
 public:
  // Keeps a reference to `player`, which must not be used otherwise during a call.
  explicit Playback(Player& player) : player_(player) {}

  // Hands in a frame and returns the image of the previous one, or null if there is none; it is
  // valid until the next call. Throws if the previous frame failed (a non-finite parameter, a
  // camera without pixels): that frame is lost, the one handed in is not.
  const RenderedImage* Next(PlaybackFrame frame);
  // The image of the last frame; null if it was already returned or failed.
  const RenderedImage* Finish();

  // Posed vertices of the frame whose image was returned last, [V, 3] metres; not valid after an
  // exception.
  const std::vector<float>& vertices() { return player_.VerticesOf(places_[drawn_]); }

 private:
  const RenderedImage* Step(std::optional<PlaybackFrame> next);
  // Places the frame while another is rendered; returns the exception, if any.
  std::exception_ptr Pose(const PlaybackFrame& frame, size_t place);

  Player& player_;
  std::array<PosedAvatar, 2> places_;
  std::optional<PlaybackFrame> waiting_;  // handed in, not yet rendered
  std::exception_ptr waiting_error_;      // why it could not be placed
  size_t waiting_place_ = 0;
  size_t drawn_ = 0;
};

}  // namespace cosplat

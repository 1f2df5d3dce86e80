// Plays a sequence with the stages of neighbouring frames beside each other: while one frame is
// drawn, the next is posed and bound.
//
// PlaybackFrame n -> Playback::Next -> image n - 1. One frame of latency; images come in order
// and have the bits that Player::RenderOver gives, for any number of threads.
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
  // Keeps a reference to `player`, which is not to be used otherwise during a call.
  explicit Playback(Player& player) : player_(player) {}

  // Hands in a frame. Returns the image of the one before, null where there is none; it stays
  // until the next call. Throws what is wrong with the frame before (a parameter that is not
  // finite, a camera without pixels): that one is lost, the one handed in is not.
  const RenderedImage* Next(PlaybackFrame frame);
  // The image of the last frame; null where it was returned, or refused, before.
  const RenderedImage* Finish();

  // Posed vertices of the frame whose image was returned last, [V, 3] metres; not after an
  // exception.
  const std::vector<float>& vertices() { return player_.VerticesOf(places_[drawn_]); }

 private:
  const RenderedImage* Step(std::optional<PlaybackFrame> next);
  // Places the frame beside the one that is drawn; returns what went wrong.
  std::exception_ptr Place(const PlaybackFrame& frame, size_t place);

  Player& player_;
  std::array<PlacedAvatar, 2> places_;
  std::optional<PlaybackFrame> waiting_;  // handed in, not yet drawn
  std::exception_ptr waiting_error_;      // why it could not be placed
  size_t waiting_place_ = 0;
  size_t drawn_ = 0;
};

}  // namespace cosplat

// What the fit compares of a frame: fields of one number over its part with the head and chest.
// Private to flame/fit/.
//
// Frame -> BandPass, RimDistance -> FrameField -> SampleAt -> FieldCost (flame/fit/field_cost.h)
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "flame/fit/landmark_cost.h"
#include "splat/base/image.h"

namespace cosplat::internal {

// How a frame sees the head. Camera axes are OpenGL's: x right, y up, looking along -z.
struct FrameView {
  FitLens lens;
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // of the head's frame to the camera's
  std::array<double, 3> translation{};                        // metres
  std::array<double, 4> box{};  // left, top, right, bottom in px: where the head and chest are
  double face_size = 0;         // px, side of a square of the face's area
};

// A point of the head's frame in the camera's axes.
std::array<double, 3> InView(const FrameView& view, const std::array<double, 3>& point);
// From the derivative with respect to InView's result to that by the point.
std::array<double, 3> InViewVjp(const FrameView& view, const std::array<double, 3>& d_out);

struct FrameField {
  double scale = 1;                // its pixels per pixel of the frame
  std::array<double, 2> corner{};  // of its first pixel, in pixels of the frame
  Image image;                     // [height, width, 1]
};

// Brightness without what varies slowly, such as shading, and without single pixels' noise, in
// 8-bit levels. frame: RGB, or RGBA with a matte, outside of which nothing counts: a background
// stands still while the head moves before it. box: left, top, right, bottom in px of the frame; is
// clipped. scale: at most 1, and such that a face has about kBandPassFace pixels.
constexpr double kBandPassFace = 160;
FrameField BandPass(const Image8& frame, const std::array<double, 4>& box, double scale);

// How far a place is outside the matte's rim, in px of the frame; negative inside. frame: RGBA.
// Nothing if the matte has no rim in the box.
std::optional<FrameField> RimDistance(const Image8& frame,
                                      const std::array<double, 4>& box,
                                      double scale);

struct FieldAt {
  double value = 0, d_x = 0, d_y = 0;  // of the field; by px of the frame
  bool inside = false;                 // of the part; otherwise all are zero
};
// Bilinear. x, y: px of the frame.
FieldAt SampleAt(const FrameField& field, double x, double y);

struct FrameFields {
  FrameField brightness;
  std::optional<FrameField> rim;
};
// views: none for frames to leave out, whose fields are empty. image(f): RGB or RGBA with a matte;
// asked for once, in order, for every frame with a view.
std::vector<FrameFields> ReadFields(const std::vector<std::optional<FrameView>>& views,
                                    const std::function<Image8(size_t f)>& image);

}  // namespace cosplat::internal

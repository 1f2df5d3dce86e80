// Where a detector sees its points on people, as points of a head model's skin.
//
// A person's track and landmarks -> CastPoints -> a place at rest per landmark; several people's ->
// PlaceOnSkin -> FlameModel::landmarks. A detector puts its points elsewhere on a rendered head
// than on people's photographs.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "flame/io/landmarks.h"
#include "flame/model.h"
#include "flame/track.h"

namespace cosplat {

// [model.landmarks] metres, on the template; nothing where it was not seen.
using CastPlaces = std::vector<std::optional<std::array<double, 3>>>;

// Rays through the points of `marks` onto the posed mesh of the frames of the same name, at most
// some hundred, each brought to the template by its place in its triangle; the median over the
// frames. A ray counts where it meets skin that faces the camera, close to where the model has the
// point now; points on eyes are left out. Throws Error if the images of both differ in size, if
// fewer than three frames have one face, or if most points miss the head.
CastPlaces CastPoints(const FlameModel& model, TrackedVideo& video, const LandmarkVideo& marks);

struct PlacedPoints {
  LandmarkEmbedding landmarks;                // in the order of the model's
  std::vector<std::array<double, 3>> places;  // of each, before it is brought to the skin
  int seen = 0;                               // of them were cast, the others stay
  double moved = 0;                           // RMS of those from the model's places, metres
  double people = 0;                          // RMS of the people's places from their mean
  double symmetry = 0;                        // RMS of right and left from their mean
};

// The mean over people, and over a point and that of the other side, on the nearest triangle.
PlacedPoints PlaceOnSkin(const FlameModel& model, const std::vector<CastPlaces>& people);

}  // namespace cosplat

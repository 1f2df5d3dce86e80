// A film for a camera's place: the made head talks, and a bar at the lower edge says which frame it
// is, so that who sees the film can tell when it was shown.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace cosplat {

struct LatencyFilm {
  static constexpr int kWidth = 640, kHeight = 480, kFramesPerSecond = 30;
  // The bar's cells, from left to right the bits of the frame's number, the lowest first; white
  // is 1. apps/landmarks/page/camera.js reads them.
  static constexpr int kCells = 12, kCellHeight = 16;  // px; a cell is kWidth / kCells wide
  struct Truth {                                       // of a face
    float jaw = 0;                                     // radians
    std::array<float, 2> lids{};                       // left, right; 1: shut
    std::array<float, 3> turn{};  // of the head, axis times angle, FLAME's axes
  };
  std::string path;           // .y4m
  std::vector<Truth> frames;  // the film is repeated
};

// Writes `folder`/film.y4m, and what it is made of beside it. Throws Error as WriteProceduralVideo
// does.
LatencyFilm MakeLatencyFilm(const std::string& folder, int frames);

}  // namespace cosplat

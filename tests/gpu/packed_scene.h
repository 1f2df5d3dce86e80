// A static scene in one file that is read without any library: what a bare machine with a GPU
// trains on (cosplat_pack_scene writes it, `cosplat_bench_cuda scene` reads it).
//
// Made to become small when it is compressed: images are stored as what a prediction leaves. All
// numbers are little-endian:
//
//   16 bytes           "CoSplat scene 1\n"
//   4 x uint32         training views, test views, points, whether the background shall be white
//   float              extent
//   points x 3 float   positions
//   points x 3 uint8   colours
//   of every view      3 x int32: width, height, channels (3 or 4);
//                      16 float: fx fy cx cy, rotation, translation (splat/base/camera.h)
//   of every view      its image: planes of width x height bytes, row by row
//
// An image's planes are alpha (if it has any), green, red - green and blue - green, modulo 256; of
// each number is stored what it is more, modulo 256, than its neighbours to the left (a), above (b)
// and above left (c) foretell: the median of a, b and a + b - c (LOCO-I; Weinberger et al. 2000),
// with 0 for neighbours beyond the border.
#pragma once

#include <ostream>
#include <string>

#include "splat/train/subject/scene_subject.h"

namespace cosplat::test {

void WritePackedScene(std::ostream& out, const TrainingScene& scene);

// Throws Error, naming file and field, on anything but a whole file with what a training can begin
// with.
TrainingScene ReadPackedScene(const std::string& path);

}  // namespace cosplat::test

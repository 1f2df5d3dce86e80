#include "apps/cosplat/run/latency_film.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "assets/head/procedural_head.h"
#include "assets/head/video.h"
#include "avatar/math/turn.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr int kWidth = LatencyFilm::kWidth, kHeight = LatencyFilm::kHeight;

LatencyFilm::Truth TruthOf(const FlameParams& face) {
  const auto lid = [&](Expression blink) { return face.expression[size_t(blink)]; };
  return {face.pose[2][0],
          {lid(Expression::kBlinkLeft), lid(Expression::kBlinkRight)},
          math::AxisAngleOf(math::Multiply(math::QuatOfAxisAngle(face.pose[0]),
                                           math::QuatOfAxisAngle(face.pose[1])))};
}

// The head in the middle, over grey.
Image8 FrameOf(const Image8& head, size_t number) {
  Image8 frame(kWidth, kHeight, 3);
  std::fill(frame.data.begin(), frame.data.end(), uint8_t(128));
  Paste(head, (kWidth - head.width) / 2, 0, frame);
  for (int y = kHeight - LatencyFilm::kCellHeight; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const int cell = x * LatencyFilm::kCells / kWidth;
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = (number >> cell & 1) != 0 ? 255 : 0;
    }
  return frame;
}

// 4:2:0, BT.601, as Chromium reads films.
std::string Yuv(const Image8& image) {
  std::string luma, blue, red;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double r = image.at(x, y, 0), g = image.at(x, y, 1), b = image.at(x, y, 2);
      const double grey = 0.299 * r + 0.587 * g + 0.114 * b;
      luma += char(std::lround(16 + grey * 219 / 255));
      if (x % 2 != 0 || y % 2 != 0) continue;
      blue += char(std::lround(128 + 224.0 / 255 * (b - grey) / 1.772));
      red += char(std::lround(128 + 224.0 / 255 * (r - grey) / 1.402));
    }
  return luma + blue + red;
}

}  // namespace

LatencyFilm MakeLatencyFilm(const std::string& folder, int frames) {
  MakeHeadOptions options;
  options.frames = frames + 1;
  options.test_frames = 1;
  options.size = kHeight;
  options.frontal = true;
  WriteProceduralVideo(folder, options);
  const TrackedVideo video = LoadDrivingSequence(folder);
  LatencyFilm film;
  film.path = folder + "/film.y4m";
  std::ofstream file(film.path, std::ios::binary);
  file << "YUV4MPEG2 W" << kWidth << " H" << kHeight << " F" << LatencyFilm::kFramesPerSecond
       << ":1 Ip A1:1 C420mpeg2\n";
  for (size_t i = 0; i < size_t(frames); ++i) {
    film.frames.push_back(TruthOf(InstantsOf(video)[i]->params));
    const std::string name = folder + "/image/" + std::to_string(i + 1) + ".png";
    file << "FRAME\n" << Yuv(FrameOf(RgbOf(ReadImage(name)), i));
  }
  file.close();
  if (!file) throw Error(film.path, "cannot be written");
  return film;
}

}  // namespace cosplat

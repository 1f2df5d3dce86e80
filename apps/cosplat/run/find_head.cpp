// FrameSource::Cuts -> ShotsBetween -> FaceDetector on a few frames of each -> ShotsAlike ->
// HeadCrop.
#include "apps/cosplat/run/find_head.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "apps/cosplat/run/face_detector.h"
#include "apps/cosplat/run/progress_bar.h"
#include "flame/fit/choose_person.h"
#include "flame/fit/choose_shots.h"
#include "flame/fit/face_looks.h"
#include "flame/fit/head_crop.h"
#include "flame/io/landmarks.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Frames in which the head is looked for, and their longer side, px.
constexpr int kCoarseFrames = 64, kFramesOfWindows = 12, kFirstFramesOfWindows = 3;
constexpr int kCoarseSide = 640;
// Apart by so much, no face is taken for one that moved.
constexpr double kApart = 1000;  // milliseconds

using Faces = std::vector<DetectedFace>;

// What was found in some frames. Faces: px of the frame, of one person in each shot.
struct Sample {
  std::vector<int> frames;   // increasing
  std::vector<Faces> faces;  // [frames]
  bool is_alone = true;      // nobody else is in any shot

  size_t with_faces() const {
    return size_t(std::count_if(faces.begin(), faces.end(), [](auto& f) { return !f.empty(); }));
  }
};

// What all steps of the search are about.
struct HeadSearch {
  const FrameSource& frames;
  int size;
  bool quiet;
  std::vector<Shot> shots;

  Sample Look(int count, const std::vector<Crop>& windows) const;
  Sample LookForSmall() const;
  void KeepPeople(Sample& sample) const;
  std::vector<FaceLook> LooksOf(const Sample& sample) const;
};

// Squares of half the frames' shorter side that overlap by half.
std::vector<Crop> SmallWindows(int width, int height) {
  const int side = std::max(1, std::min(width, height) / 2);
  const auto places = [&](int length) {
    std::vector<int> at;
    const int count = 1 + (length - side + side / 2 - 1) / std::max(1, side / 2);
    for (int i = 0; i < count; ++i) at.push_back(count > 1 ? i * (length - side) / (count - 1) : 0);
    return at;
  };
  std::vector<Crop> windows;
  for (const int y : places(height))
    for (const int x : places(width)) windows.push_back({x, y, side, side});
  return windows;
}

// Faces in some `count` frames spread over the video, which are looked for in each of the windows,
// all of one size.
Sample HeadSearch::Look(int count, const std::vector<Crop>& windows) const {
  Sample sample;
  sample.frames = SampleShots(shots, count);
  const size_t total = sample.frames.size();
  std::vector<double> times;
  for (size_t i = 0; i < total * windows.size(); ++i) times.push_back(kApart * double(i));
  const Crop& first = windows[0];
  const double scale = std::min(1.0, double(kCoarseSide) / std::max(first.width, first.height));
  const int width = std::max(1, int(std::lround(scale * first.width)));
  const int height = std::max(1, int(std::lround(scale * first.height)));
  FaceDetector detector(width, height, quiet);
  ProgressBar bar("find the head", int(total + times.size()), quiet);
  ForFrames(
      frames,
      sample.frames,
      [&](size_t i, const Image8& image) {
        for (size_t w = 0; w < windows.size(); ++w)
          detector.Add(i * windows.size() + w,
                       ResizeByArea(Cropped(image, windows[w]), width, height));
      },
      [&](int done) { bar.Update(done, "images"); });
  detector.Run(times, false, [&](int done) { bar.Update(int(total) + done, "images"); });
  const auto found = detector.Faces();
  sample.faces.resize(total);
  for (size_t i = 0; i < found.size(); ++i)
    for (DetectedFace face : found[i]) {
      const Crop& w = windows[i % windows.size()];
      for (auto& [x, y] : face.points) {
        x = w.x + x * w.width / width;
        y = w.y + y * w.height / height;
      }
      sample.faces[i / windows.size()].push_back(std::move(face));
    }
  KeepPeople(sample);
  return sample;
}

void HeadSearch::KeepPeople(Sample& sample) const {
  size_t i = 0;
  for (const Shot& shot : shots) {
    const size_t begin = i;
    while (i < sample.frames.size() && sample.frames[i] < shot.end) ++i;
    std::vector<Faces> of_shot(sample.faces.begin() + long(begin), sample.faces.begin() + long(i));
    sample.is_alone = KeepPerson(of_shot).is_alone && sample.is_alone;
    std::move(of_shot.begin(), of_shot.end(), sample.faces.begin() + long(begin));
  }
}

// The same for a head that is too small for the detector in whole frames, which sees no face that
// is smaller than some twentieth of its image. Few frames are searched by windows, and the others
// where these have the head, unless it is not there.
Sample HeadSearch::LookForSmall() const {
  const int width = frames.width(), height = frames.height();
  const std::vector<Crop> windows = SmallWindows(width, height);
  const Sample first = Look(kFirstFramesOfWindows, windows);
  if (first.with_faces() > 0) {
    const FrameCrop head = HeadCrop(first.faces, width, height, size);
    const Crop& part = head.part;
    Crop around{0, 0, std::min(2 * part.width, width), std::min(2 * part.height, height)};
    around.x = std::clamp(part.x - part.width / 2, 0, width - around.width);
    around.y = std::clamp(part.y - part.height / 2, 0, height - around.height);
    Sample near = Look(kCoarseFrames, {around});
    if (2 * near.with_faces() >= near.frames.size()) return near;
  }
  return Look(kFramesOfWindows, windows);
}

std::vector<FaceLook> HeadSearch::LooksOf(const Sample& sample) const {
  std::vector<FaceLook> looks(sample.frames.size());
  ForFrames(frames, sample.frames, [&](size_t i, const Image8& image) {
    if (sample.faces[i].empty()) return;
    const DetectedFace& face = sample.faces[i][0];
    looks[i] = {sample.frames[i], BoxOf(face.points).size(), FaceColorsOf(image, face.points)};
  });
  std::erase_if(looks, [](const FaceLook& look) { return look.colors.empty(); });
  return looks;
}

std::vector<int> FramesOf(const std::vector<Shot>& shots) {
  std::vector<int> frames;
  for (const Shot& shot : shots)
    for (int f = shot.begin; f < shot.end; ++f) frames.push_back(f);
  return frames;
}

bool IsIn(const std::vector<Shot>& shots, int frame) {
  return std::any_of(shots.begin(), shots.end(), [&](const Shot& shot) {
    return shot.begin <= frame && frame < shot.end;
  });
}

std::string LeftOutText(size_t all, size_t used, int frames, int frame_count) {
  return Format(
      "is cut into {} shots; {} of them, {} of {} frames, show one face from one distance and are "
      "used, the others are left out",
      all,
      used,
      frames,
      frame_count);
}

}  // namespace

std::vector<FaceBox> FoundHead::ExpectedIn(const std::vector<int>& which) const {
  std::vector<FaceBox> expected;
  if (seen.empty()) return expected;
  size_t k = 0;
  for (const int frame : which) {
    while (k + 1 < seen.size() &&
           std::abs(seen[k + 1].first - frame) <= std::abs(seen[k].first - frame))
      ++k;
    FaceBox box = seen[k].second;
    if (crop) {
      const auto [left, top] = crop->InImage({box.left, box.top});
      const auto [right, bottom] = crop->InImage({box.right, box.bottom});
      box = {left, top, right, bottom};
    }
    expected.push_back(box);
  }
  return expected;
}

FoundHead FindHead(const std::string& source, const FrameSource& frames, int size, bool quiet) {
  const int width = frames.width(), height = frames.height();
  const double rate = frames.frames_per_second() > 0 ? frames.frames_per_second() : 25;
  HeadSearch search{frames, size, quiet, ShotsBetween(frames.Cuts(), frames.count(), rate)};
  FoundHead found;
  const bool crops = size > 0 && std::max(width, height) > size;
  const bool is_cut = search.shots.size() > 1;
  if (!crops && !is_cut) {
    found.frames = FramesOf(search.shots);
    return found;
  }
  Sample sample = search.Look(kCoarseFrames, {{0, 0, width, height}});
  if (2 * sample.with_faces() < sample.frames.size()) {
    Sample small = search.LookForSmall();
    if (small.with_faces() * sample.frames.size() > sample.with_faces() * small.frames.size())
      sample = std::move(small);
  }
  if (sample.with_faces() == 0)
    throw Error(
        source,
        Format("has no face in any of {} frames that were looked at", sample.frames.size()));
  if (is_cut) {
    std::vector<Shot> alike;
    for (const size_t s : ShotsAlike(search.shots, search.LooksOf(sample)))
      alike.push_back(search.shots[s]);
    for (size_t i = 0; i < sample.frames.size(); ++i)
      if (!IsIn(alike, sample.frames[i])) sample.faces[i].clear();
    if (alike.size() < search.shots.size())
      found.notes.push_back(
          source + ": " +
          LeftOutText(
              search.shots.size(), alike.size(), int(FramesOf(alike).size()), frames.count()));
    search.shots = alike;
  }
  found.frames = FramesOf(search.shots);
  found.is_alone = sample.is_alone;
  for (size_t i = 0; i < sample.frames.size(); ++i)
    if (!sample.faces[i].empty())
      found.seen.emplace_back(sample.frames[i], BoxOf(sample.faces[i][0].points));
  if (crops) found.crop = HeadCrop(sample.faces, width, height, size);
  return found;
}

}  // namespace cosplat

// SMIRK's parameters: the head of tests/flame/tracked_head.h as its encoder would give it is seen
// where its own orthographic camera puts it; what is damaged gives one line.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "flame/track.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/media/image_io.h"
#include "tests/flame/tracked_head.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// SMIRK's parameters of a head like the one above, seen by an orthographic camera in a crop that
// follows the face.
struct Smirk {
  static constexpr int kWidth = 400, kHeight = 300;
  const FlameModel model = HeadModel();
  TemporaryFolder folder;
  std::map<std::string, std::vector<float>> arrays;
  bool with_tform = true;
  size_t count = kHeadFrames;

  // pixels[i] = where SMIRK's own projection and crop put the vertices of frame i in the image.
  std::vector<std::vector<Pixel>> pixels;

  explicit Smirk(bool crop = true) : with_tform(crop) {
    for (int i = 0; i < kHeadFrames; ++i) {
      const HeadFrame frame = HeadAt(i);
      const auto add = [&](const char* name, const auto& numbers) {
        for (const auto number : numbers) arrays[name].push_back(float(number));
      };
      const auto add_vector = [&](const char* name, const Vec3<double>& v) {
        add(name, std::array{v.x, v.y, v.z});
      };
      add("expression_params", frame.expression);
      add("shape_params", HeadShape());
      add_vector("pose_params", frame.root);
      add_vector("jaw_params", frame.jaw);
      add("eyelid_params", frame.eyelids);
      // scale, tx, ty; full-image pixels to crop's: skimage's matrix, of indices of pixels.
      const std::array<double, 3> cam = {7 + 0.2 * i, 0.01 * i - 0.03, 0.02 - 0.004 * i};
      add("cam", cam);
      const double a = 1.6 - 0.03 * i, bx = -150.25 - 5 * i, by = -80.5 + 3 * i;
      add("tform", std::array<double, 9>{a, 0, bx, 0, a, by, 0, 0, 1});
      std::vector<Pixel> seen;
      for (const Vec3<double>& v : FrameVertices(frame)) {
        // In the crop, from its corner: normalised coordinates -1 to 1, y down.
        const double u = 112 * (1 + cam[0] * (v[0] + cam[1]));
        const double w = 112 * (1 - cam[0] * (v[1] + cam[2]));
        seen.push_back(crop ? Pixel{(u - 0.5 - bx) / a + 0.5, (w - 0.5 - by) / a + 0.5}
                            : Pixel{u * kWidth / 224, w * kHeight / 224});
      }
      pixels.push_back(seen);
    }
  }

  // SMIRK's mesh: the eyes look ahead, the root turns about its joint.
  std::vector<Vec3<double>> FrameVertices(HeadFrame frame) const {
    frame.left_eye = frame.right_eye = frame.translation = {};
    return WorldVertices(model, frame);
  }

  Npz File() const {
    Npz npz(folder / "smirk.npz");
    for (const auto& [name, values] : arrays) {
      if (name == "tform" && !with_tform) continue;
      if (name == "tform" && values.size() == 9 * count) {
        npz.Add(name, {count, 3, 3}, values);
      } else {
        npz.Add(name, {count, values.size() / count}, values);
      }
    }
    npz.Add("image_size", {2}, std::vector<int32_t>{kHeight, kWidth});
    npz.Add("fps", {}, std::vector<float>{30});
    return npz;
  }
  const std::string& Write() const {
    File().Write(folder / "smirk.npz");
    return folder.path();
  }
  void WriteImages(int images, int first = 1) const {
    MakeDirectories(folder / "images");
    for (int i = 0; i < images; ++i)
      WriteImage(folder / ("images/" + std::to_string(i + first) + ".png"),
                 Image8(kWidth / 4, kHeight / 4, 4, uint8_t(i + first)));
  }
};

TEST(SmirkTrack, ReprojectsEveryVertex) {
  for (const bool crop : {true, false}) {
    const Smirk set(crop);
    for (const std::string& path : {set.Write(), set.folder / "smirk.npz"}) {
      const TrackedVideo video = LoadDrivingSequence(path);
      EXPECT_EQ(video.layout, "smirk");
      EXPECT_EQ(video.frames_per_second, 30);
      EXPECT_EQ(video.shape, HeadShape());
      EXPECT_EQ(video.train.empty(), path.ends_with(".npz"));
      const auto frames = AllFrames(video);
      ASSERT_EQ(frames.size(), size_t(kHeadFrames));
      double largest = 0;
      for (size_t i = 0; i < frames.size(); ++i) {
        const auto seen = TrackPixels(set.model, video.shape, frames[i]);
        largest = std::max(largest, LargestDifference(seen, set.pixels[i]));
        // The rest is the perspective of a camera at 100 m, and rounding.
        const auto vertices = set.FrameVertices(HeadAt(int(i)));
        const double center[] = {Smirk::kWidth / 2.0, Smirk::kHeight / 2.0};
        for (size_t v = 0; v < seen.size(); ++v)
          for (size_t k = 0; k < 2; ++k)
            EXPECT_NEAR(seen[v][k] - center[k],
                        (set.pixels[i][v][k] - center[k]) * 100 / (100 - vertices[v][2]),
                        1e-3);
        EXPECT_EQ(frames[i].camera.translation, frames[0].camera.translation);
        EXPECT_EQ(frames[i].camera.cx, Smirk::kWidth / 2);
        EXPECT_EQ(frames[i].params.eyelids, HeadAt(int(i)).eyelids);
        EXPECT_EQ(frames[i].params.pose[3], (std::array<float, 3>{}));
        for (size_t k = 0; k < 3; ++k) {
          EXPECT_EQ(frames[i].params.pose[0][k], float(HeadAt(int(i)).root[k]));
          EXPECT_EQ(frames[i].params.pose[2][k], float(HeadAt(int(i)).jaw[k]));
        }
      }
      EXPECT_LT(largest, 1);  // measured: 0.27 and 0.51 px, for vertices up to 0.25 m deep
    }
  }
}

TEST(SmirkTrack, RowsBelongToImagesInOrder) {
  Smirk set;
  set.WriteImages(kHeadFrames);  // 1.png, ..., 12.png: 10 comes after 9
  TrackedVideo video = LoadTrackedVideo(set.Write(), {});
  ASSERT_EQ(video.train.size(), 10u);
  EXPECT_EQ(video.train[9].name, "10");
  EXPECT_EQ(video.train[9].timestep, 9);
  EXPECT_EQ(video.test[1].name, "12");
  EXPECT_EQ(video.train[0].camera.width, Smirk::kWidth / 4);
  EXPECT_EQ(LoadTrackedImage(video, video.train[9]).at(3, 3, 0), 10);
  // Frames without a face have no row.
  set.WriteImages(30, 0);
  ExpectError([&] { LoadTrackedVideo(set.Write(), {}); },
              {"smirk.npz", "frame_numbers", "12 rows and 30 images"});
  for (int i = 0; i < kHeadFrames; ++i)
    set.arrays["frame_numbers"].push_back(float(i < 6    ? 2 * i
                                                : i == 6 ? 99
                                                : i == 7 ? -1
                                                         : i + 10));
  video = LoadTrackedVideo(set.Write(), {});
  EXPECT_EQ(video.train[3].name, "6");
  EXPECT_EQ(video.test[1].name, "21");
  ASSERT_EQ(video.skipped.size(), 2u);
  ExpectSkipped(video, 0, "99", {"there are only 30 images"});
  ExpectSkipped(video, 1, "7", {"frame_numbers of row 7", "no number"});
  WriteFileAtomically(set.folder / "images/frame.png", "");
  ExpectError([&] { LoadTrackedVideo(set.Write(), {}); }, {"frame.png", "must be a number"});
}

TEST(SmirkTrack, AVideoFileServesAsImages) {
  Smirk set;
  VideoWriter writer(set.folder / "video.mp4", 100, 76, 25);
  for (int i = 0; i < kHeadFrames; ++i) writer.Write(Image8(100, 76, 3, uint8_t(20 * i)));
  writer.Finish();
  const TrackedVideo video = LoadTrackedVideo(set.Write(), {});
  ASSERT_EQ(video.train.size(), 10u);
  EXPECT_EQ(video.train[4].video_frame, 4);
  EXPECT_EQ(video.train[4].camera.width, 100);
  EXPECT_NEAR(LoadTrackedImage(video, video.train[4]).at(3, 3, 1), 80, 6);
}

TEST(SmirkTrack, BadRowsAreSkippedAndListed) {
  Smirk set;
  set.arrays["expression_params"][6 * 1 + 2] = kNan;
  set.arrays["cam"][3 * 2] = -1;
  set.arrays["tform"][9 * 3 + 1] = 0.5f;
  set.arrays["cam"][3 * 4] = 1e-38f;
  const TrackedVideo video = LoadDrivingSequence(set.Write());
  ASSERT_EQ(video.skipped.size(), 4u);
  ExpectSkipped(video, 0, "1", {"expression_params of row 1", "[2] is not finite"});
  ExpectSkipped(video, 1, "2", {"cam of row 2 has a scale of -1"});
  ExpectSkipped(video, 2, "3", {"tform of row 3 is no scale and shift"});
  ExpectSkipped(video, 3, "4", {"row 4 are too large or too small"});
  // A frame's shape that is broken does not matter; one coefficient of all frames does.
  set.arrays["shape_params"][0] = kNan;
  EXPECT_EQ(LoadDrivingSequence(set.Write()).shape, HeadShape());
  for (int i = 0; i < kHeadFrames; ++i) set.arrays["shape_params"][size_t(5 * i + 3)] = kNan;
  ExpectError([&] { LoadDrivingSequence(set.Write()); }, {"shape_params", "finite coefficient 3"});
}

TEST(SmirkTrack, ArraysThatDisagree) {
  const struct {
    const char* name;
    std::vector<size_t> shape;
    std::vector<std::string> parts;
  } cases[] = {
      {"pose_params", {11, 3}, {"smirk.npz", "pose_params", "11 rows, expected 12"}},
      {"jaw_params", {12, 2}, {"jaw_params", "2 numbers a frame, expected 3"}},
      {"cam", {12, 4}, {"cam", "4 numbers a frame, expected 3"}},
      {"eyelid_params", {12, 1}, {"eyelid_params", "1 numbers a frame, expected 2"}},
      {"tform", {12, 2, 3}, {"tform", "6 numbers a frame, expected 9"}},
      {"image_size", {3}, {"image_size", "height and width"}},
      {"crop_size", {1}, {"crop_size", "is 0.000000 px"}},
      {"fps", {0}, {"fps", "is empty"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const Smirk set;
    Npz npz = set.File();
    size_t count = 1;
    for (const size_t extent : c.shape) count *= extent;
    npz.Add(c.name, c.shape, std::vector<float>(count, 0.f));
    npz.Write(npz.path());
    ExpectError([&] { LoadDrivingSequence(set.folder.path()); }, c.parts);
  }
  // Without a required array it is either no such file or an error.
  Smirk set;
  set.arrays.erase("jaw_params");
  set.arrays.erase("eyelid_params");  // optional
  ExpectError([&] { LoadDrivingSequence(set.Write()); }, {"smirk.npz", "jaw_params", "missing"});
}

}  // namespace
}  // namespace cosplat::test

// What WriteImavatarTrack writes is read back as the same head in the same camera.
#include "flame/io/imavatar_writer.h"

#include <gtest/gtest.h>

#include "splat/base/files.h"
#include "splat/base/json.h"
#include "tests/flame/random_model.h"
#include "tests/flame/tracked_head.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

TrackedVideo TrackOfHead() {
  TrackedVideo track;
  track.shape = test::HeadShape();
  for (int i = 0; i < test::kHeadFrames; ++i) {
    const test::HeadFrame head = test::HeadAt(i);
    TrackedFrame frame;
    frame.name = std::to_string(i + 1);
    frame.camera.width = frame.camera.height = test::kHeadSide;
    frame.camera.fx = frame.camera.fy = float(test::kHeadFocal);
    frame.camera.cx = float(test::kHeadCenter[0]);
    frame.camera.cy = float(test::kHeadCenter[1]);
    for (size_t k = 0; k < 9; ++k) frame.camera.rotation[k] = float(test::kHeadCameraRotation.m[k]);
    for (size_t k = 0; k < 3; ++k) {
      frame.camera.translation[k] = float(test::kHeadCameraTranslation[k]);
      frame.params.translation[k] = float(head.translation[k]);
      frame.params.pose[0][k] = float(head.root[k]);
      frame.params.pose[2][k] = float(head.jaw[k]);
      frame.params.pose[3][k] = float(head.left_eye[k]);
      frame.params.pose[4][k] = float(head.right_eye[k]);
    }
    frame.params.expression = head.expression;
    frame.params.eyelids = head.eyelids;
    track.train.push_back(frame);
  }
  track.static_offset = {0.001f, -0.25f, 3};
  return track;
}

const std::vector<std::array<float, 4>> kBoxes(test::kHeadFrames);

TEST(ImavatarWriter, IsReadAsTheSameHead) {
  const test::TemporaryFolder folder;
  TrackedVideo track = TrackOfHead();
  WriteImavatarTrack(folder.path(), track, kBoxes);
  MakeDirectories(folder / "image");
  for (const TrackedFrame& frame : track.train)
    WriteImage(folder / ("image/" + frame.name + ".png"),
               Image8(test::kHeadSide, test::kHeadSide, 4, 255));
  const TrackedVideo read = LoadTrackedVideo(folder.path(), {});
  EXPECT_EQ(read.test.size(), 2u);  // a fifth, since the file names no number
  EXPECT_EQ(read.static_offset, track.static_offset);
  const FlameModel model = test::HeadModel();
  const std::vector<TrackedFrame> frames = test::AllFrames(read);
  ASSERT_EQ(frames.size(), track.train.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].params.eyelids, track.train[i].params.eyelids);
    EXPECT_LT(test::LargestDifference(test::TrackPixels(model, read.shape, frames[i]),
                                      test::HeadPixels(model, int(i))),
              0.01);
  }
}

TEST(ImavatarWriter, HoldsOutAsManyFramesAsAsked) {
  const test::TemporaryFolder folder;
  WriteImavatarTrack(folder.path(), TrackOfHead(), kBoxes, 5);
  const Json json = ReadJson(folder / "flame_params.json");
  EXPECT_EQ(json["test_frames"], 5);
}

TEST(ImavatarWriter, FramesTheMask) {
  Image8 mask(8, 4, 1);
  mask.at(2, 1, 0) = 255;
  mask.at(3, 2, 0) = 255;
  EXPECT_EQ(ImavatarBox(mask), (std::array<float, 4>{-0.5f, -0.5f, 0, 0.5f}));
}

// Coefficients mean nothing to a model with another mesh.
TEST(ImavatarWriter, SaysWhichMeshTheTrackIsOf) {
  const test::TemporaryFolder folder;
  TrackedVideo track = TrackOfHead();
  track.model_vertices = 40;
  WriteImavatarTrack(folder.path(), track, kBoxes);
  const FlameModel same = test::RandomModel(40, 100, 100), other = test::RandomModel(41, 100, 100);
  EXPECT_EQ(LoadDrivingSequence(folder.path()).model_vertices, 40);
  EXPECT_NO_THROW(LoadDrivingSequence(folder.path(), &same));
  test::ExpectError([&] { LoadDrivingSequence(folder.path(), &other); },
                    {folder.path(), "40 vertices", "41"});
  // Of equal meshes, those of two versions of our own head.
  track.model_sha256 = "abc";
  WriteImavatarTrack(folder.path(), track, kBoxes);
  FlameModel version = same;
  version.sha256 = "abc";
  EXPECT_NO_THROW(LoadDrivingSequence(folder.path(), &version));
  version.sha256 = "def";
  test::ExpectError([&] { LoadDrivingSequence(folder.path(), &version); },
                    {folder.path(), "sha256 abc", "def"});
  track.model_sha256.clear();
  // Where it is not said, it is FLAME's: not that of a model with landmarks of its own.
  track.model_vertices = 0;
  WriteImavatarTrack(folder.path(), track, kBoxes);
  FlameModel own = same;
  own.landmarks = {{33, {0, 1, 2}, {1, 0, 0}}};
  EXPECT_NO_THROW(LoadDrivingSequence(folder.path(), &other));
  test::ExpectError([&] { LoadDrivingSequence(folder.path(), &own); },
                    {folder.path(), "FLAME's", own.name});
}

}  // namespace
}  // namespace cosplat

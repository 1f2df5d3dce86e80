// The layouts of metrical-tracker and INSTA: one head (tests/flame/tracked_head.h) written in each,
// and in IMavatar's, is seen at the same pixels; what is damaged gives one line.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "flame/track.h"
#include "splat/base/npz.h"
#include "tests/flame/metrical_fixture.h"
#include "tests/support/expect_error.h"

namespace cosplat::test {
namespace {

using Json = nlohmann::json;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// The head in IMavatar's layout: its motion in the parameters and the cameras' translations.
struct ImavatarHead {
  TemporaryFolder folder;
  const std::string& Write() const {
    const double side = kHeadSide;
    Json json = {
        {"intrinsics",
         {-kHeadFocal / side, kHeadFocal / side, kHeadCenter[0] / side, kHeadCenter[1] / side}},
        {"shape_params", HeadShape()},
        {"frames", Json::array()}};
    for (int i = 0; i < kHeadFrames; ++i) {
      const HeadFrame frame = HeadAt(i);
      // OpenGL's axes, for a mesh enlarged four times; the head's translation is the camera's.
      Json matrix = Json::array();
      for (int r = 0; r < 3; ++r) {
        const double sign = r == 0 ? 1 : -1;
        double t = kHeadCameraTranslation[r];
        Json row = Json::array();
        for (int k = 0; k < 3; ++k) {
          t += kHeadCameraRotation.m[3 * r + k] * frame.translation[k];
          row.push_back(sign * kHeadCameraRotation.m[3 * r + k]);
        }
        row.push_back(4 * sign * t);
        matrix.push_back(row);
      }
      std::vector<double> pose;
      for (const Vec3<double>& joint :
           {frame.root, Vec3<double>{}, frame.jaw, frame.left_eye, frame.right_eye})
        pose.insert(pose.end(), {joint.x, joint.y, joint.z});
      json["frames"].push_back({{"file_path", "./image/" + std::to_string(i + 1)},
                                {"world_mat", matrix},
                                {"expression", frame.expression},
                                {"pose", pose}});
    }
    WriteFileAtomically(folder / "flame_params.json", json.dump());
    return folder.path();
  }
};

TEST(TrackLayout, IsKnownByItsFiles) {
  const TemporaryFolder empty;
  EXPECT_EQ(TrackLayoutOf(empty.path()), "");
  EXPECT_EQ(TrackLayoutOf(ImavatarHead().Write()), "imavatar");
  EXPECT_EQ(TrackLayoutOf(Metrical(1).Write()), "metrical-tracker");
  MakeDirectories(empty / "checkpoint");  // without a .frame it is something else's
  EXPECT_EQ(TrackLayoutOf(empty.path()), "");
  const std::string frames = empty / "transforms_train.json";
  WriteFileAtomically(frames, R"({"frames": [{"file_path": "a", "flame_param_path": "b"}]})");
  EXPECT_EQ(TrackLayoutOf(empty.path()), "vhap");
  WriteFileAtomically(frames, R"({"frames": [{"file_path": "a", "exp_path": "b"}]})");
  EXPECT_EQ(TrackLayoutOf(empty.path()), "insta");
  WriteFileAtomically(frames, R"({"frames": [{"file_path": "a"}]})");  // a scene
  EXPECT_EQ(TrackLayoutOf(empty.path()), "");
  Npz npz;
  npz.Add("expr", {1, 1}, std::vector<float>{0});
  npz.Write(empty / "drive.npz");
  EXPECT_EQ(TrackLayoutOf(empty / "drive.npz"), "npz");
}

TEST(MetricalTrack, ReprojectsEveryVertex) {
  const Metrical set;
  const TrackedVideo moved = LoadDrivingSequence(set.Write(), &set.model);
  const TrackedVideo fixed = LoadDrivingSequence(set.folder.path());
  EXPECT_EQ(moved.layout, "metrical-tracker");
  EXPECT_FALSE(moved.head_is_fixed);
  EXPECT_TRUE(fixed.head_is_fixed);
  const auto a = AllFrames(moved), b = AllFrames(fixed);
  ASSERT_EQ(a.size(), size_t(kHeadFrames));
  for (int i = 0; i < kHeadFrames; ++i) {
    EXPECT_EQ(a[size_t(i)].timestep, i);
    // 1e-3 px; measured: 3e-4, rounding of the file's float32.
    const auto truth = HeadPixels(set.model, i);
    EXPECT_LT(LargestDifference(TrackPixels(set.model, moved.shape, a[size_t(i)]), truth), 1e-3);
    EXPECT_LT(LargestDifference(TrackPixels(set.model, fixed.shape, b[size_t(i)]), truth), 1e-3);
    // One camera for all frames, in front of the head.
    EXPECT_EQ(a[size_t(i)].camera.rotation, (std::array<float, 9>{1, 0, 0, 0, -1, 0, 0, 0, -1}));
    EXPECT_EQ(a[size_t(i)].camera.translation, a[0].camera.translation);
    EXPECT_EQ(b[size_t(i)].params.pose[0], (std::array<float, 3>{}));
    EXPECT_EQ(a[size_t(i)].params.eyelids, HeadAt(i).eyelids);
    EXPECT_TRUE(a[size_t(i)].params.shape.empty());
    // The root's rotation is the head's, whatever the first frame's was.
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(a[size_t(i)].params.pose[0][size_t(k)], HeadAt(i).root[size_t(k)], 1e-5);
  }
  EXPECT_EQ(moved.shape, HeadShape());
}

// The tracker's own camera, PyTorch3D's, in place of the OpenCV one that is read.
TEST(MetricalTrack, AgreesWithTheTrackersOwnCamera) {
  const Metrical set;
  const TrackedVideo video = LoadDrivingSequence(set.Write(), &set.model);
  const auto frames = AllFrames(video);
  for (int i = 0; i < kHeadFrames; ++i) {
    const MetricalValues values = MetricalAt(set.model, i);
    const std::vector<float>& six = values.camera.at("R").numbers;
    Mat3<double> r;
    for (int k = 0; k < 6; ++k) r.m[k] = six[size_t(k)];
    const Vec3<double> third = math::Cross(math::ToVec3(r.m), math::ToVec3(r.m + 3));
    for (int k = 0; k < 3; ++k) r(2, k) = third[k];
    const std::vector<float>&t = values.camera.at("t").numbers,
          &pp = values.camera.at("pp").numbers;
    std::vector<Pixel> pixels;
    for (const Vec3<double>& v : RestVertices(set.model, HeadAt(i))) {
      Vec3<double> p = math::TransposeTimes(r, v);  // a row vector from the left
      for (int k = 0; k < 3; ++k) p[k] += t[size_t(k)];
      const double focal = values.camera.at("fl").numbers[0], half = kHeadSide / 2.0;
      pixels.push_back({half - half * (focal * p[0] / p[2] + pp[0]),
                        half - half * (focal * p[1] / p[2] + pp[1])});
    }
    EXPECT_LT(LargestDifference(TrackPixels(set.model, video.shape, frames[size_t(i)]), pixels),
              1e-3);
  }
}

TEST(MetricalTrack, IsTheHeadOfImavatarsLayout) {
  const Metrical set;
  const ImavatarHead imavatar;
  const auto a = AllFrames(LoadDrivingSequence(set.Write(), &set.model));
  const auto b = AllFrames(LoadDrivingSequence(imavatar.Write()));
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].camera.rotation, b[i].camera.rotation);
    EXPECT_EQ(a[i].params.expression, b[i].params.expression);
    for (int j = 0; j < kFlameJoints; ++j)
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(
            a[i].params.pose[size_t(j)][size_t(k)], b[i].params.pose[size_t(j)][size_t(k)], 1e-5);
    // The worlds differ by where the first frame's camera is put: all vertices by one vector.
    std::vector<Vec3<double>> in_a, in_b;
    TrackPixels(set.model, HeadShape(), a[i], &in_a);
    TrackPixels(set.model, HeadShape(), b[i], &in_b);
    for (size_t v = 0; v < in_a.size(); ++v)
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(in_a[v][size_t(k)], in_b[v][size_t(k)], 1e-6);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(a[i].params.translation[size_t(k)] - b[i].params.translation[size_t(k)],
                  a[0].params.translation[size_t(k)] - b[0].params.translation[size_t(k)],
                  1e-6);
  }
}

TEST(MetricalTrack, ImagesMasksAndSplit) {
  Metrical set;
  const TrackOptions options{-1, 1, &set.model};
  ExpectError([&] { LoadTrackedVideo(set.Write(), options); },
              {"has no folder images, image or input"});
  set.WriteImages("input", 3);
  TrackedVideo video = LoadTrackedVideo(set.folder.path(), options);
  EXPECT_EQ(video.train.size(), 10u);  // a fifth is held out
  EXPECT_EQ(video.test[0].name, "00010");
  EXPECT_EQ(video.train[1].camera.width, 32);
  EXPECT_FLOAT_EQ(video.train[1].camera.fx, float(kHeadFocal / 16));
  EXPECT_EQ(LoadTrackedImage(video, video.train[1]).at(3, 3, 0), 11);
  set.WriteImages("mask", 1);
  video = LoadTrackedVideo(set.folder.path(), options);
  EXPECT_EQ(LoadTrackedImage(video, video.train[1]).at(3, 3, 3), 255);  // a label: all are below 32
  set.WriteImages("images", 4);  // INSTA's, with alpha: preferred
  video = LoadTrackedVideo(set.folder.path(), {3, 1, &set.model});
  EXPECT_NE(video.train[0].image_path.find("/images/"), std::string::npos);
  EXPECT_EQ(video.test.size(), 3u);
  // Of a long video, the last 350 frames are held out, as in the published comparisons.
  for (int i = kHeadFrames; i < 1800; ++i) set.frames[i] = set.frames[i % kHeadFrames];
  EXPECT_EQ(LoadDrivingSequence(set.Write()).test.size(), 350u);
}

TEST(MetricalTrack, BadFramesAreSkippedAndListed) {
  Metrical set(50);
  set.frames[0].flame["jaw"].numbers = {1, 0, 0, 2, 0, 0};
  set.frames[1].flame["exp"].numbers[3] = kNan;
  set.frames[2].flame.erase("eyes");
  set.frames[3].flame["eyes"] = {{1, 6}, {1, 0, 0, 0, 1, 0}};
  set.frames[4].opencv["K"].numbers[0] = kNan;
  set.frames[5].opencv["R"].numbers[0] = 3;
  set.frames[6].opencv["t"].numbers[1] = kNan;
  set.frames[7].img_size = {0, 512};
  set.frames[9].flame["shape"].numbers[2] += 1;
  set.frames[10].flame["eyelids"].numbers[0] = kNan;
  set.frames[11].opencv.clear();
  set.Write();
  const std::string good = TorchArchive(MetricalPickle(set.frames[20]));
  set.WriteCheckpoint(8, good.substr(0, good.size() / 2));
  set.WriteCheckpoint(12,
                      TorchArchive(pickle::Reduce(pickle::Class("os", "system"),
                                                  pickle::Tuple({pickle::Text("true")}))));
  WriteFileAtomically(set.folder / "checkpoint/last.frame", good);
  // Without eyelids, as from earlier versions of the tracker: open.
  set.frames[49].flame.erase("eyelids");
  set.WriteCheckpoint(49, TorchArchive(MetricalPickle(set.frames[49])));
  const TrackedVideo video = LoadDrivingSequence(set.folder.path(), &set.model);
  EXPECT_EQ(AllFrames(video).size(), 37u);
  EXPECT_EQ(video.test.back().params.eyelids, (std::array<float, 2>{}));
  ASSERT_EQ(video.skipped.size(), 14u);
  EXPECT_NE(video.skipped[0].name.find("last.frame"), std::string::npos);
  const struct {
    const char* name;
    std::vector<std::string> words;
  } expected[] = {{"00000", {"00000.frame", "flame.jaw is no rotation"}},
                  {"00001", {"flame.exp[3] is not finite"}},
                  {"00002", {"00002.frame", "flame.eyes", "is missing"}},
                  {"00003", {"flame.eyes", "6 numbers, expected 12"}},
                  {"00004", {"opencv.K", "not finite"}},
                  {"00005", {"00005.frame", "not orthonormal"}},
                  {"00006", {"translation that is not finite"}},
                  {"00007", {"img_size has a side of 0"}},
                  {"00008", {"00008.frame", "torch.save"}},
                  {"00010", {"flame.eyelids[0] is not finite"}},
                  {"00011", {"00011.frame", "opencv.K", "is missing"}},
                  {"00012", {"00012.frame", "class os.system is not accepted"}},
                  {"00009", {"flame.shape[2] is 1.2", "in other frames 0.2"}}};
  for (size_t i = 0; i < 13; ++i) ExpectSkipped(video, i + 1, expected[i].name, expected[i].words);
  for (int i = 13; i < 22; ++i) set.WriteCheckpoint(i, "");
  ExpectError([&] { LoadDrivingSequence(set.folder.path()); }, {"23 of 51"});
}

// INSTA's files beside the tracker's checkpoints.
struct Insta {
  Metrical tracker;
  Json file = {{"w", double(kHeadSide)},
               {"h", double(kHeadSide)},
               {"cx", kHeadCenter[0]},
               {"cy", kHeadCenter[1]},
               {"fl_x", kHeadFocal},
               {"fl_y", kHeadFocal},
               {"frames", Json::array()}};
  Json train, test;

  explicit Insta(int first_test = 9) {
    tracker.WriteImages("images", 4);
    tracker.Write();
    train = test = file;
    // As a pool of processes returns them: not in order.
    for (const int i : {2, 0, 1, 3, 5, 4, 6, 7, 8, 10, 9, 11}) {
      const HeadCamera camera = CameraAboutHead(tracker.model, HeadAt(i));
      Json matrix = Json::array();
      for (int r = 0; r < 3; ++r) {
        double center = 0;
        for (int k = 0; k < 3; ++k) center -= camera.rotation(k, r) * camera.translation[k];
        matrix.push_back(
            {camera.rotation(0, r), camera.rotation(1, r), camera.rotation(2, r), center});
      }
      matrix.push_back({0, 0, 0, 1});
      const std::string name = FrameName(i);
      const Json frame = {{"transform_matrix", matrix},
                          {"file_path", "images/" + name + ".png"},
                          {"mesh_path", "meshes/" + name + ".obj"},
                          {"exp_path", "flame/exp/" + name + ".txt"}};
      file["frames"].push_back(frame);
      (i < first_test ? train : test)["frames"].push_back(frame);
    }
  }
  const std::string& Write() const {
    const std::string& folder = tracker.folder.path();
    WriteFileAtomically(folder + "/transforms.json", file.dump());
    WriteFileAtomically(folder + "/transforms_train.json", train.dump());
    WriteFileAtomically(folder + "/transforms_test.json", test.dump());
    return folder;
  }
  TrackedVideo Load(int test_frames = -1) const {
    return LoadTrackedVideo(Write(), {test_frames, 1, &tracker.model});
  }
};

TEST(InstaTrack, ReprojectsEveryVertexAndIsTheTrackersHead) {
  const Insta set;
  const TrackedVideo video = LoadDrivingSequence(set.Write(), &set.tracker.model);
  EXPECT_EQ(video.layout, "insta");
  const auto frames = AllFrames(video);
  ASSERT_EQ(frames.size(), size_t(kHeadFrames));
  for (int i = 0; i < kHeadFrames; ++i) {
    EXPECT_EQ(frames[size_t(i)].timestep, i);
    EXPECT_LT(LargestDifference(TrackPixels(set.tracker.model, video.shape, frames[size_t(i)]),
                                HeadPixels(set.tracker.model, i)),
              1e-3);
    EXPECT_EQ(frames[size_t(i)].params.eyelids, HeadAt(i).eyelids);
  }
  for (const char* name : {"transforms.json", "transforms_train.json", "transforms_test.json"})
    std::filesystem::remove(set.tracker.folder / name);
  const auto tracker =
      AllFrames(LoadDrivingSequence(set.tracker.folder.path(), &set.tracker.model));
  for (size_t i = 0; i < frames.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(
          frames[i].params.translation[size_t(k)], tracker[i].params.translation[size_t(k)], 1e-6);
      EXPECT_NEAR(frames[i].params.pose[0][size_t(k)], tracker[i].params.pose[0][size_t(k)], 1e-6);
    }
}

TEST(InstaTrack, Splits) {
  Insta set;
  TrackedVideo video = set.Load();
  EXPECT_EQ(video.train.size(), 9u);  // its own split
  EXPECT_EQ(video.test[0].name, "00009");
  EXPECT_EQ(video.train[0].camera.width, 32);
  EXPECT_EQ(LoadTrackedImage(video, video.train[2]).at(1, 1, 3), 21);
  EXPECT_EQ(set.Load(1).test[0].name, "00011");
  // With no more than 350 frames INSTA's script leaves none to train on: a fifth is held out.
  Insta few(0);
  video = few.Load();
  EXPECT_EQ(video.train.size(), 10u);
  EXPECT_EQ(video.test.size(), 2u);
  // transforms.json alone.
  for (const char* name : {"transforms_train.json", "transforms_test.json"})
    std::filesystem::remove(few.tracker.folder / name);
  video = LoadTrackedVideo(few.tracker.folder.path(), {-1, 1, &few.tracker.model});
  EXPECT_EQ(video.layout, "insta");
  EXPECT_EQ(video.test[1].name, "00011");
}

TEST(InstaTrack, WhatItLacksIsNamed) {
  const Insta set;
  std::filesystem::rename(set.tracker.folder / "checkpoint", set.tracker.folder / "elsewhere");
  ExpectError([&] { set.Load(); }, {"checkpoint/", "no jaw, eyes and shape", "metrical-tracker"});
  ExpectError([&] { LoadDrivingSequence(set.Write()); }, {"checkpoint/", "is missing"});
  Insta neither;
  for (Json* json : {&neither.file, &neither.train, &neither.test})
    for (Json& frame : (*json)["frames"]) {
      frame.erase("exp_path");
      frame.erase("mesh_path");
    }
  std::filesystem::rename(neither.tracker.folder / "checkpoint",
                          neither.tracker.folder / "elsewhere");
  ExpectError([&] { neither.Load(); },
              {"transforms_train.json", "flame_param_path (VHAP", "exp_path (INSTA)"});
}

TEST(InstaTrack, BadFramesAreSkippedAndListed) {
  Insta set;
  Json& frames = set.train["frames"];  // 2, 0, 1, 3, ...
  frames[0]["file_path"] = "../../secret/00002.png";
  frames[1]["transform_matrix"][0][0] = 3;
  std::filesystem::remove(set.tracker.folder / "images/00001.png");
  std::filesystem::remove(set.tracker.folder / "checkpoint/00003.frame");
  TrackedVideo video = set.Load();
  EXPECT_EQ(AllFrames(video).size(), 8u);
  ASSERT_EQ(video.skipped.size(), 4u);
  ExpectSkipped(video, 0, "00002", {"file_path ../../secret/00002.png leads out of the folder"});
  ExpectSkipped(video, 1, "00000", {"not orthonormal"});
  ExpectSkipped(video, 2, "00001", {"images/00001.png is missing"});
  ExpectSkipped(video, 3, "00003", {"checkpoint/00003.frame is missing"});
  frames[4]["file_path"] = "/etc/passwd";
  ExpectError([&] { set.Load(); }, {"5 of 12", "leads out of the folder"});
  // A checkpoint of another frame, as when images and checkpoints are counted from 0 and 1.
  Insta shifted;
  shifted.tracker.WriteCheckpoint(6, TorchArchive(MetricalPickle(shifted.tracker.frames[7])));
  video = shifted.Load();
  ASSERT_EQ(video.skipped.size(), 1u);
  ExpectSkipped(
      video, 0, "00006", {"transform_matrix is not the camera of", "checkpoint/00006.frame"});
}

TEST(InstaTrack, JsonErrorsNameTheField) {
  const struct {
    const char* pointer;
    Json value;
    std::vector<std::string> parts;
  } cases[] = {
      {"/w", 0, {"transforms_train.json", "frames[0]", "not positive"}},
      {"/fl_x", "x", {"transforms_train.json", "fl_x", "\"x\""}},
      {"/frames/2/transform_matrix", 3, {"frames[2].transform_matrix", "an array"}},
      {"/frames/2/file_path", 3, {"frames[2].file_path", "a string"}},
      {"/frames", Json::object(), {"frames", "an array"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.pointer);
    Insta set;
    set.train[Json::json_pointer(c.pointer)] = c.value;
    ExpectError([&] { set.Load(); }, c.parts);
  }
}

}  // namespace
}  // namespace cosplat::test

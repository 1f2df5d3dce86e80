// The layouts of metrical-tracker, INSTA and SMIRK: one head (tests/flame/tracked_head.h) written
// in each, and in IMavatar's, is seen at the same pixels; what is damaged gives one line.
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

std::vector<TrackedFrame> AllFrames(const TrackedVideo& video) {
  std::vector<TrackedFrame> all = video.train;
  all.insert(all.end(), video.test.begin(), video.test.end());
  return all;
}

// Where a track's camera sees the mesh of its parameters.
std::vector<Pixel> TrackPixels(const FlameModel& model,
                               const std::vector<float>& shape,
                               const TrackedFrame& frame,
                               std::vector<Vector3<double>>* in_camera = nullptr) {
  const FlamePoser<double> poser(model, shape);
  std::vector<double> v;
  poser.Forward(FlamePoser<double>::ParametersOf(frame.params), v);
  const Camera& c = frame.camera;
  std::vector<Pixel> pixels;
  for (size_t i = 0; i < v.size(); i += 3) {
    Vector3<double> q;
    for (int r = 0; r < 3; ++r) {
      q[r] = c.translation[r];
      for (int k = 0; k < 3; ++k) q[r] += double(c.rotation[3 * r + k]) * v[i + k];
    }
    EXPECT_GT(q[2], 0);
    if (in_camera) in_camera->push_back(q);
    pixels.push_back({c.fx * q[0] / q[2] + c.cx, c.fy * q[1] / q[2] + c.cy});
  }
  return pixels;
}

double LargestDifference(const std::vector<Pixel>& a, const std::vector<Pixel>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (int k = 0; k < 2; ++k) largest = std::max(largest, std::abs(a[i][k] - b[i][k]));
  return largest;
}

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
          t += kHeadCameraRotation[3 * r + k] * frame.translation[k];
          row.push_back(sign * kHeadCameraRotation[3 * r + k]);
        }
        row.push_back(4 * sign * t);
        matrix.push_back(row);
      }
      std::vector<double> pose;
      for (const Vector3<double>& joint :
           {frame.root, Vector3<double>{}, frame.jaw, frame.left_eye, frame.right_eye})
        pose.insert(pose.end(), joint.begin(), joint.end());
      json["frames"].push_back({{"file_path", "./image/" + std::to_string(i + 1)},
                                {"world_mat", matrix},
                                {"expression", frame.expression},
                                {"pose", pose}});
    }
    WriteFileAtomically(folder / "flame_params.json", json.dump());
    return folder.path();
  }
};

void ExpectSkipped(const TrackedVideo& video,
                   size_t i,
                   const std::string& name,
                   const std::vector<std::string>& words) {
  ASSERT_LT(i, video.skipped.size());
  EXPECT_EQ(video.skipped[i].name, name);
  EXPECT_EQ(video.skipped[i].reason.find('\n'), std::string::npos);
  for (const std::string& word : words)
    EXPECT_NE(video.skipped[i].reason.find(word), std::string::npos)
        << "'" << video.skipped[i].reason << "' lacks '" << word << "'";
}

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
    Matrix3<double> r;  // rows
    for (int k = 0; k < 6; ++k) r[size_t(k)] = six[size_t(k)];
    r[6] = r[1] * r[5] - r[2] * r[4];
    r[7] = r[2] * r[3] - r[0] * r[5];
    r[8] = r[0] * r[4] - r[1] * r[3];
    const std::vector<float>&t = values.camera.at("t").numbers,
          &pp = values.camera.at("pp").numbers;
    std::vector<Pixel> pixels;
    for (const Vector3<double>& v : RestVertices(set.model, HeadAt(i))) {
      Vector3<double> p = flame_math::TransposeTimes(r, v);  // a row vector from the left
      for (int k = 0; k < 3; ++k) p[size_t(k)] += t[size_t(k)];
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
    std::vector<Vector3<double>> in_a, in_b;
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
  EXPECT_EQ(LoadTrackedImage(video, video.train[1]).at(3, 3, 3), 11);
  set.WriteImages("images", 4);  // INSTA's, with alpha: preferred
  video = LoadTrackedVideo(set.folder.path(), {3, 1, &set.model});
  EXPECT_NE(video.train[0].image_path.find("/images/"), std::string::npos);
  EXPECT_TRUE(video.train[0].mask_path.empty());
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
        for (int k = 0; k < 3; ++k)
          center -= camera.rotation[size_t(3 * k + r)] * camera.translation[size_t(k)];
        matrix.push_back({camera.rotation[size_t(r)],
                          camera.rotation[size_t(3 + r)],
                          camera.rotation[size_t(6 + r)],
                          center});
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
      add("expression_params", frame.expression);
      add("shape_params", HeadShape());
      add("pose_params", frame.root);
      add("jaw_params", frame.jaw);
      add("eyelid_params", frame.eyelids);
      // scale, tx, ty; full-image pixels to crop's: skimage's matrix, of indices of pixels.
      const std::array<double, 3> cam = {7 + 0.2 * i, 0.01 * i - 0.03, 0.02 - 0.004 * i};
      add("cam", cam);
      const double a = 1.6 - 0.03 * i, bx = -150.25 - 5 * i, by = -80.5 + 3 * i;
      add("tform", std::array<double, 9>{a, 0, bx, 0, a, by, 0, 0, 1});
      std::vector<Pixel> seen;
      for (const Vector3<double>& v : FrameVertices(frame)) {
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
  std::vector<Vector3<double>> FrameVertices(HeadFrame frame) const {
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

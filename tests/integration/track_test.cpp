// `cosplat track`, from a video and its landmarks to an avatar that trains on the result.
#include "flame/track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "assets/head/procedural_head.h"
#include "assets/head/rig.h"
#include "flame/io/landmarks.h"
#include "flame/model.h"
#include "flame/pose.h"
#include "splat/base/files.h"
#include "tests/integration/command.h"

namespace cosplat {
namespace {

using test::CommandResult;
using test::Cosplat;
using test::TemporaryFolder;

// The made head's video, its landmarks with a pixel of noise.
struct Filmed {
  TemporaryFolder folder;
  std::string head = folder / "head", images = head + "/image", marks = head + "/landmarks.json";
  std::string track = folder / "track";
  LandmarkVideo video;

  Filmed() {
    const CommandResult made = Cosplat({"make-head",
                                        "-o",
                                        head,
                                        "--frames",
                                        "24",
                                        "--size",
                                        "128",
                                        "--test-frames",
                                        "4",
                                        "--landmark-noise",
                                        "0.3",
                                        "--quiet"});
    EXPECT_EQ(made.code, 0) << made.err;
    video = ReadLandmarks(marks);
  }

  CommandResult Track(const std::vector<std::string>& more = {}, const char* rounds = "0") const {
    std::vector<std::string> arguments{"track", images, "--landmarks", marks, "-o", track};
    arguments.insert(arguments.end(), {"--avatar-rounds", rounds});
    arguments.insert(arguments.end(), {"--flame", head + "/model.npz"});
    arguments.insert(arguments.end(), {"--landmark-embedding", head + "/landmark_embedding.npz"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Cosplat(arguments);
  }

  void ExpectRefused(const std::vector<std::string>& words,
                     const std::vector<std::string>& more = {}) const {
    const CommandResult result = Track(more);
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    for (const std::string& word : words)
      EXPECT_NE(result.err.find(word), std::string::npos) << result.err << " lacks " << word;
    EXPECT_FALSE(std::filesystem::exists(track)) << "something was written";
  }

  // The landmarks with something changed, as a file of their own.
  void Change(const std::function<void(LandmarkVideo&)>& change) {
    LandmarkVideo changed = video;
    change(changed);
    WriteLandmarks(marks, changed);
  }
};

TEST(Track, MakesAVideoThatAvatarsTrainOn) {
  Filmed filmed;
  filmed.Change([](LandmarkVideo& video) { video.frames[5].faces.clear(); });
  const std::string overlay = filmed.folder / "overlay.mp4";
  const CommandResult result = filmed.Track({"--overlay", overlay}, "1");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("23 of 24 frames"), std::string::npos) << result.out;
  EXPECT_NE((result.out + result.err).find("6: has no face"), std::string::npos)
      << result.out << result.err;
  EXPECT_EQ(VideoReader(overlay).frame_count(), 23);

  TrackOptions options;
  options.test_frames = 4;
  const TrackedVideo track = LoadTrackedVideo(filmed.track, options);
  const TrackedVideo truth = LoadTrackedVideo(filmed.head, options);
  EXPECT_EQ(track.train.size() + track.test.size(), 23u);
  EXPECT_NEAR(track.train[0].camera.fx / truth.train[0].camera.fx, 1, 0.1);
  const Image8 image = LoadTrackedImage(track, track.train[0]);
  EXPECT_EQ(image.data, LoadTrackedImage(truth, truth.train[0]).data);

  const Json figures = ReadJson(filmed.track + "/track.json");
  EXPECT_LT(figures["error_px"].get<double>(), 0.6);
  EXPECT_GE(figures["brightness_spread"].size(), 1u);
  const auto psnr = figures["held_out_psnr"].get<std::vector<double>>();
  ASSERT_EQ(psnr.size(), 2u);
  EXPECT_EQ(result.out.find("none is kept") != std::string::npos, psnr[1] <= psnr[0]) << result.out;
  EXPECT_NE(result.out.find("small avatars had not seen"), std::string::npos) << result.out;
  EXPECT_EQ(ReadJson(filmed.track + "/skipped_frames.json")[0]["name"], "6");
  EXPECT_NE(result.out.find("for a better avatar: There are 23 frames"), std::string::npos)
      << result.out;
  EXPECT_NE(test::Slurp(filmed.track + "/track.html").find("data:image/jpeg"), std::string::npos);

  const CommandResult trained = Cosplat({"train-avatar",
                                         "-s",
                                         filmed.track,
                                         "--flame",
                                         filmed.head + "/model.npz",
                                         "-m",
                                         filmed.folder / "avatar",
                                         "--iterations",
                                         "60",
                                         "--gaussians",
                                         "1500",
                                         "--eval",
                                         "--quiet"});
  EXPECT_EQ(trained.code, 0) << trained.err;
}

TEST(Track, SaysThatTheImageCutsTheHeadOff) {
  Filmed filmed;
  const std::string said = "for a better avatar: The image cuts the head off in 24 of 24 frames";
  const CommandResult whole = filmed.Track();
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(whole.out.find("cuts the head off"), std::string::npos) << whole.out;
  filmed.Change([](LandmarkVideo& video) {
    for (LandmarkFrame& frame : video.frames)
      for (auto& [x, y] : frame.faces[0].points) y -= 40;
  });
  std::filesystem::remove_all(filmed.track);
  const CommandResult cut = filmed.Track();
  EXPECT_EQ(cut.code, 0) << cut.err;
  EXPECT_NE(cut.out.find(said), std::string::npos) << cut.out;
}

TEST(Track, SaysFromWhereTheFaceLooksDifferent) {
  const Filmed filmed;
  for (size_t f = 12; f < 24; ++f) {
    const std::string path = filmed.images + "/" + filmed.video.frames[f].name + ".png";
    Image8 image = ReadImage(path);
    for (size_t i = 0; i < image.data.size(); ++i)
      if (image.channels < 4 || i % 4 < 3) image.data[i] = uint8_t(255 - image.data[i]);
    WriteImage(path, image);
  }
  const CommandResult result = filmed.Track();
  EXPECT_EQ(result.code, 0) << result.err;
  const std::string& name = filmed.video.frames[12].name;
  EXPECT_NE(result.out.find("From frame " + name + " on the face looks"), std::string::npos)
      << result.out;
}

// Landmarks of a part of the frames: the lens is off its middle, and overlays are whole frames.
TEST(Track, TracksAPartOfTheFrames) {
  Filmed filmed;
  const FrameCrop crop{{12, 4, 112, 120}, 128, 128, 112, 120};
  filmed.Change([&](LandmarkVideo& video) {
    video.width = crop.width, video.height = crop.height;
    video.crop = crop;
    video.held_out = 5;
    for (LandmarkFrame& frame : video.frames) {
      frame.matte = "";
      for (auto& [x, y] : frame.faces[0].points) x -= crop.part.x, y -= crop.part.y;
    }
  });
  const std::string overlays = filmed.folder / "overlays";
  const CommandResult result = filmed.Track({"--overlay", overlays});
  ASSERT_EQ(result.code, 0) << result.err;
  const TrackedVideo track = LoadTrackedVideo(filmed.track, {});
  EXPECT_EQ(track.test.size(), 5u);
  const Camera& camera = track.train[0].camera;
  EXPECT_EQ(camera.width, crop.width);
  EXPECT_EQ(camera.height, crop.height);
  EXPECT_NEAR(camera.cx, 64 - crop.part.x, 0.01);
  EXPECT_NEAR(camera.cy, 64 - crop.part.y, 0.01);
  EXPECT_EQ(ReadImageInfo(track.train[0].image_path).height, crop.height);
  EXPECT_EQ(ReadImageInfo(overlays + "/00000.png").width, 128);
  filmed.Change([&](LandmarkVideo& video) {
    video.width = crop.width, video.height = crop.height;
    video.crop = crop;
    video.crop->frame_width = 256;
  });
  std::filesystem::remove_all(filmed.track);
  filmed.ExpectRefused({"crop.frame_width", "256x128", "128x128"});
}

TEST(Track, DrawsTheOutlineToTheMattes) {
  Filmed filmed;
  const CommandResult result = filmed.Track({"--silhouette", "--quiet"});
  ASSERT_EQ(result.code, 0) << result.err;
  const TrackedVideo track = LoadTrackedVideo(filmed.track, {});
  ASSERT_FALSE(track.static_offset.empty());
  float greatest = 0;
  for (float x : track.static_offset) greatest = std::max(greatest, std::abs(x));
  EXPECT_GT(greatest, 0.0005f);  // metres
  EXPECT_LT(greatest, 0.08f);
  std::filesystem::remove_all(filmed.track);
  filmed.Change([](LandmarkVideo& video) {
    for (LandmarkFrame& frame : video.frames) frame.matte.clear();
  });
  filmed.ExpectRefused({"--silhouette", filmed.marks, "mattes"}, {"--silhouette"});
}

TEST(Track, NamesWhatIsWrongAndWritesNothing) {
  Filmed filmed;
  filmed.Change([](LandmarkVideo& video) { video.width = 64; });
  filmed.ExpectRefused({filmed.marks, "64x128", "128x128"});
  filmed.Change([](LandmarkVideo& video) { video.frames[7].name = "elsewhere"; });
  filmed.ExpectRefused({filmed.marks, "frames[7].name", "'elsewhere'", "'8'"});
  filmed.Change([](LandmarkVideo& video) { video.source_checksum = 1; });
  filmed.ExpectRefused({filmed.marks, "source_checksum: is 1", "another film"});
  filmed.Change([](LandmarkVideo& video) { video.frames.back().frame = 24; });
  filmed.ExpectRefused({filmed.marks, "frames[23].frame", "24 frames"});
  filmed.Change([](LandmarkVideo& video) {
    for (LandmarkFrame& frame : video.frames) frame.faces.clear();
  });
  filmed.ExpectRefused({filmed.marks, "has no face"});
  filmed.Change([](LandmarkVideo& video) { video.frames.resize(1); });  // a photograph
  filmed.ExpectRefused({filmed.images + ": faces found: 1, expected at least 3"});
  // A third may be missing, no more.
  filmed.Change([](LandmarkVideo& video) {
    for (size_t f = 0; f < video.frames.size(); f += 2) video.frames[f].faces.clear();
  });
  filmed.ExpectRefused({filmed.marks, "12"});
  filmed.Change([](LandmarkVideo& video) {
    for (size_t f = 0; f < video.frames.size(); ++f)
      if (f != 3) video.frames[f].matte.clear();
  });
  filmed.ExpectRefused({filmed.marks, "frames[3].matte", "earlier frames have none"});
  filmed.Change([](LandmarkVideo& video) {
    for (LandmarkFrame& frame : video.frames) frame.matte = "nowhere.png";
  });
  filmed.ExpectRefused({"nowhere.png"});
  filmed.Change([](LandmarkVideo&) {});
  filmed.ExpectRefused({"-3", "--focal"}, {"--focal", "-3"});
}

// With exact parameters there is little to gain, and nothing is lost.
TEST(Track, RefinesATrackThatThereIs) {
  const Filmed filmed;
  const std::string model = filmed.head + "/model.npz";
  const CommandResult result =
      Cosplat({"track", filmed.head, "--flame", model, "-o", filmed.track, "--avatar-rounds", "1"});
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("24 frames refined"), std::string::npos) << result.out;
  const TrackedVideo refined = LoadTrackedVideo(filmed.track, {});
  const TrackedVideo given = LoadTrackedVideo(filmed.head, {});
  ASSERT_EQ(refined.test.size(), 4u);
  ASSERT_EQ(refined.train.size(), 20u);
  EXPECT_EQ(refined.shape, given.shape);
  EXPECT_EQ(refined.train[7].camera.fx, given.train[7].camera.fx);
  EXPECT_EQ(LoadTrackedImage(refined, refined.train[7]).data,
            LoadTrackedImage(given, given.train[7]).data);
  for (size_t f = 0; f < 20; ++f)
    for (size_t j = 0; j < 2; ++j)
      for (size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(refined.train[f].params.pose[j][i], given.train[f].params.pose[j][i], 0.05);
  const Json figures = ReadJson(filmed.track + "/track.json");
  EXPECT_EQ(figures["frames"], 24);
  EXPECT_LE(figures["brightness_spread"].back().get<double>(),
            figures["brightness_spread"].front().get<double>());

  const auto expect_refused = [&](const std::vector<std::string>& arguments,
                                  const std::vector<std::string>& words) {
    const CommandResult refused = Cosplat(arguments);
    EXPECT_EQ(refused.code, 2);
    for (const std::string& word : words)
      EXPECT_NE(refused.err.find(word), std::string::npos) << refused.err << " lacks " << word;
  };
  expect_refused({"track", filmed.images, "--flame", model, "-o", filmed.folder / "no"},
                 {"--landmarks", filmed.images});
  expect_refused({"track", filmed.head, "--flame", model, "-o", filmed.head},
                 {"-o", "is the input"});
  expect_refused(
      {"track", filmed.head, "--flame", model, "-o", filmed.folder / "no", "--focal", "700"},
      {"--focal", "--landmarks"});
  EXPECT_FALSE(std::filesystem::exists(filmed.folder / "no"));
}

// The made head's landmarks as MediaPipe's, of which only those are right that our own head has.
void WriteAsMediapipes(const Filmed& filmed) {
  const ProceduralHead head = MakeProceduralHeadParts();
  const FlamePoser<float> poser(head.model, {});
  const TrackedVideo track = LoadDrivingSequence(filmed.head);
  LandmarkVideo video = filmed.video;
  video.set = LandmarkSet::kMediapipe478;
  for (size_t f = 0; f < video.frames.size(); ++f) {
    const size_t train = track.train.size();
    const TrackedFrame& frame = f < train ? track.train[f] : track.test[f - train];
    std::vector<float> vertices;
    poser.Forward(FlamePoser<float>::ParametersOf(frame.params), vertices);
    std::vector<std::array<double, 2>>& points = video.frames[f].faces[0].points;
    points.assign(478, {64, 64});
    for (const EmbeddedLandmark& mark : procedural::FacePoints(head.mesh)) {
      double at[3] = {0, 0, 0}, seen[3];
      for (size_t k = 0; k < 3; ++k)
        for (size_t i = 0; i < 3; ++i)
          at[i] += mark.barycentric[k] * vertices[3 * size_t(mark.vertices[k]) + i];
      const Camera& c = frame.camera;
      for (size_t i = 0; i < 3; ++i)
        seen[i] = c.rotation[3 * i] * at[0] + c.rotation[3 * i + 1] * at[1] +
                  c.rotation[3 * i + 2] * at[2] + c.translation[i];
      points[size_t(mark.landmark)] = {c.fx * seen[0] / seen[2] + c.cx,
                                       c.fy * seen[1] / seen[2] + c.cy};
    }
  }
  WriteLandmarks(filmed.marks, video);
}

// The whole way in one command, from landmarks that are there, without a model of anybody's.
TEST(Avatar, FromAVideoToReportAndPlayback) {
  const Filmed filmed;
  WriteAsMediapipes(filmed);
  const std::string out = filmed.folder / "me";
  const CommandResult result = Cosplat({"avatar",
                                        filmed.images,
                                        "-o",
                                        out,
                                        "--landmarks",
                                        filmed.marks,
                                        "--avatar-rounds",
                                        "0",
                                        "--iterations",
                                        "60",
                                        "--gaussians",
                                        "1500"});
  ASSERT_EQ(result.code, 3) << result.err;  // such made landmarks have half of the head outside
  for (const char* made : {"track/flame_params.json",
                           "track/track.html",
                           "avatar/avatar.glb",
                           "avatar/results.json",
                           "avatar/report.html"})
    EXPECT_TRUE(std::filesystem::exists(out + "/" + made)) << made;
  EXPECT_EQ(VideoReader(out + "/playback.mp4").frame_count(), 24);
  EXPECT_NE(result.out.find("no blendshape map"), std::string::npos) << result.out;
  const CommandResult parent = Cosplat({"render", "-m", out});
  EXPECT_EQ(parent.code, 2);
  EXPECT_NE(parent.err.find("the run of this video is " + out + "/avatar"), std::string::npos)
      << parent.err;
  const CommandResult info = Cosplat({"info", out});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_EQ(info.out, Cosplat({"info", out + "/avatar"}).out);
  const FlameModel own = LoadFlameModel(out + "/head.npz");
  EXPECT_TRUE(own.redistributable);
  EXPECT_EQ(own.expression_names.back(), "eyeBlinkRight");
  // Its track says which head it is of.
  EXPECT_EQ(LoadDrivingSequence(out + "/track/.").model_vertices, own.vertex_count);
  // The later commands find it, too.
  const int code = Cosplat({"check", out + "/track"}).code;
  EXPECT_TRUE(code == 0 || code == 3) << code;  // 3: it says what is odd
  const CommandResult again = Cosplat({"train-avatar",
                                       "-s",
                                       out + "/track",
                                       "-m",
                                       out + "/again",
                                       "--iterations",
                                       "5",
                                       "--gaussians",
                                       "500",
                                       "--quiet"});
  EXPECT_EQ(again.code, 3) << again.err;
}

// Those of earlier versions have no checksum.
TEST(Avatar, KeepsLandmarksOfTheSameFilm) {
  Filmed filmed;
  WriteAsMediapipes(filmed);
  const std::string out = filmed.folder / "me";
  MakeDirectories(out);
  uint32_t sum = 0;
  for (int i = 1; i <= 24; ++i)
    sum = Crc32OfFile(filmed.images + "/" + std::to_string(i) + ".png", sum);
  for (const bool with : {true, false}) {
    LandmarkVideo marks = ReadLandmarks(filmed.marks);
    marks.source = filmed.images;
    if (with) marks.source_checksum = sum;
    WriteLandmarks(out + "/landmarks.json", marks);
    const CommandResult result = Cosplat({"avatar", filmed.images, "-o", out, "--focal", "9"});
    EXPECT_EQ(result.code, 2) << result.err;
    EXPECT_NE(result.out.find("1/4 Landmarks are there"), std::string::npos) << result.out;
    EXPECT_NE(result.err.find("is in pixels"), std::string::npos) << result.err;
  }
}

// The best, and what others published, is not limited to what plays fast.
TEST(Avatar, LimitsItsGaussiansByDefault) {
  const Filmed filmed;
  WriteAsMediapipes(filmed);
  const auto limit = [&](const char* option, const char* value) {
    const std::string out = filmed.folder / value;
    const CommandResult result = Cosplat({"avatar",
                                          filmed.images,
                                          "-o",
                                          out,
                                          "--landmarks",
                                          filmed.marks,
                                          "--avatar-rounds",
                                          "0",
                                          option,
                                          value,
                                          "--iterations",
                                          "5",
                                          "--gaussians",
                                          "500",
                                          "--quiet"});
    EXPECT_EQ(result.code, 3) << result.err;
    const std::string config = test::Slurp(out + "/avatar/config.ini");
    const size_t at = config.find("max-gaussians=");
    return config.substr(at, config.find('\n', at) - at);
  };
  EXPECT_EQ(limit("--quality", "draft"), "max-gaussians=12000");
  EXPECT_EQ(limit("--quality", "best"), "max-gaussians=2000000");
  EXPECT_EQ(limit("--preset", "splatting-avatar"), "max-gaussians=2000000");
}

TEST(Avatar, SaysWhatIsToBeKnownOfAVideo) {
  const TemporaryFolder folder;
  const std::string images = folder / "images";
  MakeDirectories(images);
  Image8 image(96, 48, 3, 0);  // between black bars
  for (int y = 0; y < 48; ++y)
    for (int x = 32; x < 64; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = uint8_t(100 + 37 * (x * y) % 90);
  WriteImage(images + "/0.png", image);
  const CommandResult result =
      Cosplat({"avatar", images, "-o", folder / "me", "--landmarks", folder / "none.json"});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("the bars beside it are left out"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find(images + ": frames: 1, expected at least 3"), std::string::npos)
      << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "me"));
}

TEST(Avatar, NamesAVideoThatCannotBeReadBeforeAnythingElse) {
  const TemporaryFolder folder;
  std::ofstream(folder / "me.mp4") << "not a video";
  const CommandResult result =
      Cosplat({"avatar", folder / "me.mp4", "-o", folder / "me", "--flame", folder / "no.npz"});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("me.mp4"), std::string::npos) << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "me"));
}

// Frames whose landmarks are no face, or one from the side, are left out and named.
TEST(Track, LeavesOutWhatDoesNotFit) {
  Filmed filmed;
  filmed.Change([](LandmarkVideo& video) {
    for (size_t p = 0; p < video.frames[9].faces[0].points.size(); ++p)
      video.frames[9].faces[0].points[p] = {30.0 + 7 * (p % 9), 40.0 + 11 * (p % 5)};
  });
  const CommandResult result = filmed.Track();
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE((result.out + result.err).find("10: landmarks are"), std::string::npos)
      << result.out << result.err;
}

}  // namespace
}  // namespace cosplat

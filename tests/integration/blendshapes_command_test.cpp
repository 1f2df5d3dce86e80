// `train-avatar --landmarks` from end to end: the map that it fits, stores and reports, and what
// plays by it.
#include <gtest/gtest.h>

#include <algorithm>

#include "assets/head/procedural_head.h"
#include "flame/io/landmarks.h"
#include "flame/track.h"
#include "tests/integration/command.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

using test::CommandResult;
using test::Cosplat;
using test::TemporaryFolder;

constexpr int kSide = 48, kTrainFrames = 40, kTestFrames = 4;

// The made head's video with the scores of its own track.
struct ScoredHead {
  TemporaryFolder folder;
  std::string head = folder / "head", marks = folder / "marks.json";
  LandmarkVideo landmarks;

  ScoredHead() {
    const CommandResult made = Cosplat({"make-head",
                                        "-o",
                                        head,
                                        "--frames",
                                        std::to_string(kTrainFrames + kTestFrames),
                                        "--test-frames",
                                        std::to_string(kTestFrames),
                                        "--size",
                                        std::to_string(kSide),
                                        "--quiet"});
    EXPECT_EQ(made.code, 0) << made.err;
    landmarks.source = head;
    landmarks.width = landmarks.height = kSide;
    landmarks.frames_per_second = 25;
    landmarks.set = LandmarkSet::kIbug68;
    const TrackedVideo track = LoadDrivingSequence(head);
    for (const TrackedFrame* tracked : InstantsOf(track)) {
      LandmarkFrame& frame = landmarks.frames.emplace_back();
      frame.name = tracked->name;
      frame.frame = int(landmarks.frames.size()) - 1;
      frame.faces.push_back(FaceOf(tracked->params));
    }
    WriteLandmarks(marks, landmarks);
  }

  static DetectedFace FaceOf(const FlameParams& params) {
    DetectedFace face;
    face.points.assign(68, {kSide * 0.3, kSide * 0.3});
    face.points[0] = {kSide * 0.7, kSide * 0.7};
    const auto score = [](float x) { return std::clamp(x, 0.0f, 1.0f); };
    face.blendshapes["jawOpen"] = score(params.pose[2][0] / 0.3f);
    face.blendshapes["eyeBlinkLeft"] = score(params.expression[size_t(Expression::kBlinkLeft)]);
    face.blendshapes["mouthSmileLeft"] = score(params.expression[size_t(Expression::kSmileLeft)]);
    face.blendshapes["mouthPucker"] = score(params.expression[size_t(Expression::kPucker)]);
    return face;
  }

  CommandResult Train(const std::string& marks_file) const {
    return Cosplat({"train-avatar",
                    "-s",
                    head,
                    "--flame",
                    head + "/model.npz",
                    "-m",
                    folder / "out",
                    "--eval",
                    "--iterations",
                    "4",
                    "--gaussians",
                    "500",
                    "--overwrite",
                    "--landmarks",
                    marks_file});
  }
};

const ScoredHead& Scored() {
  static const ScoredHead head;
  return head;
}

TEST(TrainAvatarLandmarks, FitsStoresAndReportsAMap) {
  const CommandResult trained = Scored().Train(Scored().marks);
  ASSERT_EQ(trained.code, 0) << trained.err;
  EXPECT_NE(trained.out.find("blendshape map: "), std::string::npos) << trained.out;
  EXPECT_NE(trained.out.find("40 frames; held out in turn: R2 "), std::string::npos) << trained.out;
  EXPECT_NE(trained.out.find("; 4 test frames: R2 "), std::string::npos) << trained.out;
  const std::string out = Scored().folder / "out";
  const Json json = ReadJson(out + "/blendshapes.json");
  EXPECT_EQ(json["held_out"]["frames"], kTrainFrames);
  EXPECT_EQ(json["test"]["frames"], kTestFrames);
  EXPECT_LT(json["held_out"]["error_mm"], json["held_out"]["mean_face_error_mm"]);
  const CommandResult info = Cosplat({"info", out + "/avatar.glb"});
  EXPECT_NE(info.out.find("blendshape scores, fitted to 40 frames; held out: R2 "),
            std::string::npos)
      << info.out;
  // The scores are a recording that drives it.
  const CommandResult rendered =
      Cosplat({"render", "-m", out, "--drive", Scored().marks, "-o", Scored().folder / "driven"});
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  EXPECT_EQ(std::distance(fs::directory_iterator(Scored().folder / "driven"), {}),
            kTrainFrames + kTestFrames);
}

TEST(TrainAvatarLandmarks, TooFewScoresLeaveTheAvatarWithoutAMapAndSaySo) {
  LandmarkVideo few = Scored().landmarks;
  for (size_t i = 10; i < few.frames.size(); ++i) few.frames[i].faces.clear();
  WriteLandmarks(Scored().folder / "few.json", few);
  const CommandResult trained = Scored().Train(Scored().folder / "few.json");
  ASSERT_EQ(trained.code, 0) << trained.err;
  EXPECT_NE(trained.out.find("few.json: no blendshape map: "), std::string::npos) << trained.out;
  EXPECT_NE(trained.out.find("10 frames have any, at least 30"), std::string::npos) << trained.out;
  EXPECT_FALSE(fs::exists(Scored().folder / "out/blendshapes.json"));
  const CommandResult info = Cosplat({"info", Scored().folder / "out/avatar.glb"});
  EXPECT_EQ(info.out.find("blendshape"), std::string::npos) << info.out;
}

TEST(TrainAvatarLandmarks, ThoseOfAnotherVideoAreOneLineAndNothingIsWritten) {
  LandmarkVideo other = Scored().landmarks;
  for (LandmarkFrame& frame : other.frames) frame.name += "x";
  WriteLandmarks(Scored().folder / "other.json", other);
  fs::remove_all(Scored().folder / "out");
  const CommandResult trained = Scored().Train(Scored().folder / "other.json");
  EXPECT_EQ(trained.code, 2);
  EXPECT_NE(trained.err.find("other.json: frames: none is of this video"), std::string::npos)
      << trained.err;
  EXPECT_EQ(std::count(trained.err.begin(), trained.err.end(), '\n'), 1) << trained.err;
  EXPECT_FALSE(fs::exists(Scored().folder / "out"));
}

}  // namespace
}  // namespace cosplat

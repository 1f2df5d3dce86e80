// Bad input to the `cosplat` command: one line naming what is wrong, exit code 2, nothing
// half-written.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

#include "splat/base/npz.h"
#include "tests/integration/command.h"

namespace cosplat::test {
namespace {

namespace fs = std::filesystem;

const Workshop& Made() { return Workshop::Get(); }

void Spill(const std::string& path, const std::string& bytes) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

class BadInput : public testing::Test {
 protected:
  // "$" in an argument or part stands for the test's folder.
  std::string Filled(std::string text) const {
    for (size_t at = text.find('$'); at != std::string::npos; at = text.find('$', at))
      text.replace(at, 1, folder_.path());
    return text;
  }

  std::set<std::string> Files() const {
    std::set<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      files.insert(entry.path().string());
    return files;
  }

  // Exit code 2, nothing on standard output, one line on standard error that has every part, and no
  // new file or folder.
  void Expect(std::vector<std::string> arguments,
              const std::vector<std::string>& parts,
              const std::string& before = "") const {
    std::string shown;
    for (std::string& argument : arguments) shown += (argument = Filled(argument)) + " ";
    SCOPED_TRACE(shown);
    const std::set<std::string> files = Files();
    const CommandResult result = Cosplat(arguments, before);
    EXPECT_EQ(result.code, 2) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.err.rfind("cosplat: ", 0), 0u) << result.err;
    for (const std::string& part : parts)
      EXPECT_NE(result.err.find(Filled(part)), std::string::npos)
          << result.err << " lacks " << part;
    EXPECT_EQ(Files(), files);
  }

  void ExpectTrainAvatar(const std::vector<std::string>& parts,
                         const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{
        "train-avatar", "-s", "$/head", "-m", "$/out", "--iterations", "5"};
    if (std::find(more.begin(), more.end(), "--flame") == more.end())
      arguments.insert(arguments.end(), {"--flame", Made().model});
    arguments.insert(arguments.end(), more.begin(), more.end());
    Expect(arguments, parts);
  }

  void CopyHead() const { fs::copy(Made().head, folder_ / "head", fs::copy_options::recursive); }
  void ChangeTrack(const std::function<void(Json&)>& change) const {
    if (!fs::exists(folder_ / "head")) CopyHead();
    Json json = ReadJson(Made().head + "/flame_params.json");
    change(json);
    Spill(folder_ / "head/flame_params.json", json.dump());
  }

  const TemporaryFolder folder_;
};

TEST_F(BadInput, SourceIsMissingOrEmpty) {
  ExpectTrainAvatar({"$/head", "does not exist"});
  Expect({"train-scene", "-s", "$/photos", "-m", "$/out"}, {"$/photos"});
  fs::create_directories(folder_ / "head");
  fs::create_directories(folder_ / "photos");
  ExpectTrainAvatar({"$/head", "flame_params.json"});
  Expect({"train-scene", "-s", "$/photos", "-m", "$/out"}, {"$/photos"});
  Expect({"info", "$/photos"}, {"$/photos"});
  Expect({"info", "$/nothing"}, {"$/nothing"});
  Spill(folder_ / "file.txt", "text");
  Expect({"info", "$/file.txt"}, {"$/file.txt"});
  Expect({"train-scene", "-s", "$/file.txt", "-m", "$/out"}, {"$/file.txt"});
}

TEST_F(BadInput, TrackIsNoGoodJson) {
  const std::string file = "$/head/flame_params.json";
  CopyHead();
  Spill(folder_ / "head/flame_params.json", "{\"frames\": [");
  ExpectTrainAvatar({file, "line 1"});
  Spill(folder_ / "head/flame_params.json", "");
  ExpectTrainAvatar({file});
  ChangeTrack([](Json& json) { json["frames"] = "twelve"; });
  ExpectTrainAvatar({file, "frames", "twelve"});
  ChangeTrack([](Json& json) { json["frames"] = Json::array(); });
  ExpectTrainAvatar({"$/head"});
  ChangeTrack([](Json& json) { json.erase("intrinsics"); });
  ExpectTrainAvatar({file, "intrinsics"});
  ChangeTrack([](Json& json) { json["frames"][2].erase("pose"); });
  ExpectTrainAvatar({file, "frames[2]", "pose"});
  ChangeTrack([](Json& json) { json["frames"][2]["file_path"] = 7; });
  ExpectTrainAvatar({file, "frames[2].file_path", "7"});
  ChangeTrack([](Json& json) { json["shape_params"][1] = "wide"; });
  ExpectTrainAvatar({file, "shape_params[1]", "wide"});
}

TEST_F(BadInput, FramesCannotBeUsed) {
  ChangeTrack([](Json& json) {
    for (Json& frame : json["frames"]) frame["pose"][4] = nullptr;  // Python's NaN
  });
  ExpectTrainAvatar({"$/head", "12", "pose[4]"});
  ChangeTrack([](Json&) {});
  for (int i = 2; i <= 12; ++i)
    WriteImage(folder_ / ("head/image/" + std::to_string(i) + ".png"), Image8(48, 64, 4));
  ExpectTrainAvatar({"$/head", "11 of 12", "48x64"});
  for (int i = 1; i <= 12; ++i) {
    WriteImage(folder_ / ("head/image/" + std::to_string(i) + ".png"), Image8(64, 64, 3));
    if (i > 6) fs::remove(folder_ / ("head/mask/" + std::to_string(i) + ".png"));
  }
  ExpectTrainAvatar({"$/head", "6 of 12", "mask"});
  fs::remove_all(folder_ / "head/image");
  ExpectTrainAvatar({"$/head"});
}

TEST_F(BadInput, FlameModelIsNone) {
  CopyHead();
  const auto expect = [&](const std::string& model, const std::vector<std::string>& parts) {
    ExpectTrainAvatar(parts, {"--flame", model});
    Expect({"info", model}, parts);
  };
  expect("$/absent.pkl", {"$/absent.pkl"});
  Spill(folder_ / "text.pkl", "this is not a pickle\n");
  expect("$/text.pkl", {"$/text.pkl"});
  Spill(folder_ / "hostile.pkl", "cos\nsystem\n(S'touch " + (folder_ / "owned") + "'\ntR.");
  expect("$/hostile.pkl", {"$/hostile.pkl", "os", "system"});
  Spill(folder_ / "zip.npz", "PK\003\004 and nothing more");
  expect("$/zip.npz", {"$/zip.npz"});

  const Npz whole = Npz::Read(Made().model);
  Npz cut;
  for (const auto& [name, array] : whole.arrays()) {
    std::vector<size_t> shape = array.shape;
    std::vector<float> values(array.values.begin(), array.values.end());
    if (name == "v_template") {
      shape[0] -= 1;
      values.resize(values.size() - 3);
    }
    cut.Add(name, shape, values);
  }
  cut.Write(folder_ / "cut.npz");
  expect("$/cut.npz", {"$/cut.npz"});
}

TEST_F(BadInput, FlameModelIsAnotherThanTheAvatars) {
  const Npz whole = Npz::Read(Made().model);
  Npz other;
  for (const auto& [name, array] : whole.arrays()) {
    std::vector<float> values(array.values.begin(), array.values.end());
    if (name == "v_template") values[0] += 0.001f;
    other.Add(name, array.shape, values);
  }
  other.Write(folder_ / "other.npz");
  // The procedural head may be embedded, so its avatars carry their mesh; the model still differs.
  const CommandResult result = Cosplat({"render",
                                        "-m",
                                        Made().avatar,
                                        "--flame",
                                        folder_ / "other.npz",
                                        "--orbit",
                                        "-o",
                                        folder_ / "out"});
  EXPECT_EQ(result.code, 2) << result.err;
  EXPECT_NE(result.err.find("other.npz"), std::string::npos) << result.err;
}

TEST_F(BadInput, ColmapFilesAreCutOff) {
  fs::create_directories(folder_ / "photos/images");
  WriteImage(folder_ / "photos/images/a.png", Image8(8, 8, 3));
  Spill(folder_ / "photos/sparse/0/cameras.bin", std::string("\1\0\0\0\0\0\0\0\1\0\0\0\1\0", 14));
  Spill(folder_ / "photos/sparse/0/images.bin", std::string("\1\0\0\0\0\0\0\0\1", 9));
  Spill(folder_ / "photos/sparse/0/points3D.bin", std::string(8, '\0'));
  Expect({"train-scene", "-s", "$/photos", "-m", "$/out"}, {"$/photos/sparse/0/cameras.bin"});
  Expect({"info", "$/photos"}, {"$/photos/sparse/0/cameras.bin"});
  std::string camera("\1\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0\10\0\0\0\0\0\0\0\10\0\0\0\0\0\0\0", 32);
  for (const double value : {9.0, 9.0, 4.0, 4.0})
    camera.append(reinterpret_cast<const char*>(&value), sizeof value);
  Spill(folder_ / "photos/sparse/0/cameras.bin", camera);
  Expect({"train-scene", "-s", "$/photos", "-m", "$/out"}, {"$/photos/sparse/0/images.bin"});
  fs::remove(folder_ / "photos/sparse/0/images.bin");
  Expect({"train-scene", "-s", "$/photos", "-m", "$/out"}, {"$/photos/sparse/0", "images"});
}

TEST_F(BadInput, SceneIsDamaged) {
  fs::copy(Made().photos, folder_ / "photos", fs::copy_options::recursive);
  const std::string file = "$/photos/transforms_train.json";
  const auto change = [&](const std::function<void(Json&)>& f) {
    Json json = ReadJson(Made().photos + "/transforms_train.json");
    f(json);
    Spill(folder_ / "photos/transforms_train.json", json.dump());
  };
  const auto expect = [&](const std::vector<std::string>& parts) {
    Expect({"train-scene", "-s", "$/photos", "-m", "$/out", "--iterations", "5"}, parts);
  };
  change([](Json& json) { json["camera_angle_x"] = "wide"; });
  expect({file, "camera_angle_x", "wide"});
  change([](Json& json) { json.erase("frames"); });
  expect({file, "frames"});
  change([](Json& json) { json["frames"][1]["transform_matrix"] = {1, 2}; });
  expect({file, "frames[1].transform_matrix"});
  change([](Json& json) {
    for (Json& frame : json["frames"]) frame["transform_matrix"][0][0] = nullptr;
  });
  expect({"$/photos"});
  change([](Json&) {});
  for (int i = 0; i < 5; ++i)
    fs::remove(folder_ / ("photos/train/r_" + std::to_string(i) + ".png"));
  expect({"$/photos", "5 of 12", "r_0.png"});
}

// Their headers are good: it is found out when the run is about to begin.
TEST_F(BadInput, PhotographsAreCutOff) {
  fs::copy(Made().photos, folder_ / "photos", fs::copy_options::recursive);
  for (int i = 0; i < 5; ++i) {
    const std::string path = folder_ / ("photos/train/r_" + std::to_string(i) + ".png");
    fs::resize_file(path, fs::file_size(path) / 2);
  }
  Expect({"train-scene", "-s", "$/photos", "-m", "$/out", "--iterations", "5"},
         {"$/photos", "r_0.png"});
}

TEST_F(BadInput, OutputCannotBeWritten) {
  CopyHead();
  Spill(folder_ / "out", "a file where the folder should be");
  ExpectTrainAvatar({"$/out"});
  Expect({"train-scene", "-s", Made().photos, "-m", "$/out", "--iterations", "5"}, {"$/out"});
  Expect({"make-head", "-o", "$/out", "--frames", "2", "--test-frames", "1", "--size", "16"},
         {"$/out"});
  EXPECT_EQ(Slurp(folder_ / "out"), "a file where the folder should be");
  Expect({"render", "-m", Made().avatar, "--orbit", "-o", "$/out"}, {"$/out"});
  Expect({"render", "-m", Made().scene, "--orbit", "-o", "$/out/video.mp4"}, {"$/out/video.mp4"});
  Expect({"train-avatar", "-s", "$/head", "--flame", Made().model, "-m", "/proc/cosplat"},
         {"/proc/cosplat"});
  Expect({"render", "-m", Made().scene, "--orbit", "-o", "/proc/cosplat/video.mp4"},
         {"/proc/cosplat"});
}

// A limit on the size of files stands for a disk that is full.
TEST_F(BadInput, DiskIsFull) {
  const std::string full = "trap '' XFSZ; ulimit -f 64;";
  fs::copy(Made().avatar, folder_ / "run", fs::copy_options::recursive);
  const std::string before = Slurp(folder_ / "run/avatar.glb");
  const CommandResult result = Cosplat({"train-avatar",
                                        "--config",
                                        folder_ / "run/config.ini",
                                        "-m",
                                        folder_ / "run",
                                        "--iterations",
                                        "5"},
                                       full);
  EXPECT_EQ(result.code, 2) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_NE(result.err.find(folder_ / "run"), std::string::npos) << result.err;
  EXPECT_EQ(Slurp(folder_ / "run/avatar.glb"), before);
  for (const std::string& file : Files()) EXPECT_EQ(file.find(".tmp"), std::string::npos) << file;
  fs::remove_all(folder_ / "run");
  Expect({"render", "-m", Made().scene, "--orbit", "-o", "$/video.mp4"},
         {"$/video.mp4"},
         "trap '' XFSZ; ulimit -f 4;");
}

TEST_F(BadInput, OptionsAreWrong) {
  CopyHead();
  ExpectTrainAvatar({"--basis", "fourier"}, {"--basis", "fourier"});
  ExpectTrainAvatar({"--iterations", "many"}, {"--iterations", "many"});
  ExpectTrainAvatar({"--sh_degree", "9"}, {"--sh_degree", "9"});
  ExpectTrainAvatar({"--resolution", "0"}, {"-r", "0"});
  ExpectTrainAvatar({"--bust", "maybe"}, {"--bust", "maybe"});
  ExpectTrainAvatar({"--sharpness"}, {"--sharpness", "3"});
  ExpectTrainAvatar({"99"}, {"--test-frames", "99"});
  ExpectTrainAvatar({"$/absent.ini"}, {"--config", "$/absent.ini"});
  Spill(folder_ / "bad.ini", "train-avatar.sharpness=3\n");
  ExpectTrainAvatar({"$/bad.ini", "train-avatar.sharpness"}, {"--config", "$/bad.ini"});
  Spill(folder_ / "bad.ini", "train-avatar.basis=\"fourier\"\n");
  ExpectTrainAvatar({"--basis", "fourier"}, {"--config", "$/bad.ini"});
  Expect({}, {"subcommand"});
  Expect({"paint"}, {"'paint' is no command (--help"});
  Expect({"trian-scene", "-s", "x"}, {"'trian-scene' is no command: did you mean train-scene?"});
  Expect({"train-scene", "-s", "x", "--iteratons=5"},
         {"'--iteratons' is no option of train-scene: did you mean --iterations?"});
  Expect({"train-scene", "-s", "x", "-m", "$/out", "y"},
         {"'y' belongs to no option of train-scene"});
  Expect({"train-avatar", "-s", "$/head"}, {"required"});
  Expect({"make-head", "-o", "$/new", "--frames", "0"}, {"frames", "0"});
  Expect({"make-head"}, {"--out", "is missing"});
  Expect({"make-head", "-o", "$/new", "--frames", "3", "--test-frames", "3"}, {"3"});
  Expect({"make-head", "-o", "$/new", "--size", "7"}, {"size", "7"});
  Expect({"render", "-m", Made().avatar, "--orbit"}, {"--out"});
  Expect({"render", "-m", Made().avatar, "--orbit", "-o", "$/turn.gif"}, {"turn.gif", ".mp4"});
  Expect({"render", "-m", Made().avatar, "--preview"}, {"--preview", "--out"});
  Expect({"render", "-m", Made().avatar, "--orbit", "--drive", "$/head", "-o", "$/o"}, {"--orbit"});
  Expect({"render", "-m", Made().scene, "--drive", "$/head", "-o", "$/o"}, {"--drive"});
  Expect({"render", "-m", Made().scene, "--random", "3", "-o", "$/o"}, {"--random"});
  Expect({"render", "-m", Made().avatar, "--random", "0", "-o", "$/o"}, {"--random", "0"});
  Expect({"render", "-m", Made().avatar, "--random", "3"}, {"--out"});
  Expect({"render", "-m", Made().scene, "--device", "tpu"}, {"--device", "tpu"});
  for (const std::string& made : {Made().scene, Made().avatar})
    Expect({"render", "-m", made, "--device", "cuda"},
           {"--device", "cuda"},
           "export CUDA_VISIBLE_DEVICES=-1;");
  Expect({"train-scene", "-s", Made().photos, "-m", "$/out", "--device", "cuda"},
         {"--device", "cuda"},
         "export CUDA_VISIBLE_DEVICES=-1;");
  Expect({"train-avatar", "-s", "$/head", "-m", "$/out", "--flame", "$/none", "--device", "cuda"},
         {"--device", "cuda"},
         "export CUDA_VISIBLE_DEVICES=-1;");
}

TEST_F(BadInput, RunFolderIsNone) {
  fs::create_directories(folder_ / "run");
  for (const std::string command : {"render", "metrics", "report"})
    Expect({command, "-m", "$/run"}, {"$/run"});
  for (const std::string command : {"render", "metrics", "report"})
    Expect({command, "-m", "$/absent"}, {"$/absent"});
  Spill(folder_ / "run/run.json", "[]");
  Expect({"render", "-m", "$/run"}, {"$/run/run.json"});
  Expect({"info", "$/run"}, {"$/run/run.json"});
  Expect({"report", "-m", "$/run"}, {"$/run"});
  Json run = ReadJson(Made().avatar + "/run.json");
  run["reference"]["camera"]["intrinsics"] = {1, 2};
  Spill(folder_ / "run/run.json", run.dump());
  Expect({"render", "-m", "$/run", "--orbit", "-o", "$/o"}, {"$/run/avatar.glb"});
  fs::copy(Made().avatar + "/avatar.glb", folder_ / "run/avatar.glb");
  Expect({"render", "-m", "$/run", "--orbit", "-o", "$/o"},
         {"$/run/run.json", "reference.camera.intrinsics"});
  Expect({"render", "-m", "$/run", "--drive", "$/absent", "-o", "$/o"}, {"$/absent"});
}

TEST_F(BadInput, FilesOfARunAreDamaged) {
  fs::copy(Made().avatar, folder_ / "run", fs::copy_options::recursive);
  const std::string glb = Slurp(Made().avatar + "/avatar.glb");
  Spill(folder_ / "run/avatar.glb", glb.substr(0, glb.size() / 2));
  Expect({"render", "-m", "$/run", "--orbit", "-o", "$/o"}, {"$/run/avatar.glb"});
  Expect({"info", "$/run/avatar.glb"}, {"$/run/avatar.glb"});
  const std::string ply = "/point_cloud/iteration_120/point_cloud.ply";
  fs::copy(Made().scene, folder_ / "scene", fs::copy_options::recursive);
  const std::string splats = Slurp(Made().scene + ply);
  Spill(folder_ / ("scene" + ply), splats.substr(0, splats.size() - 7));
  Expect({"render", "-m", "$/scene", "--orbit", "-o", "$/o"}, {"$/scene" + ply});
  Expect({"info", "$/scene" + ply}, {"$/scene" + ply});
  Spill(folder_ / ("scene" + ply), "ply\nformat ascii 1.0\n");
  Expect({"info", "$/scene" + ply}, {"$/scene" + ply});
  for (const std::string file : {"stats.json", "results.json", "per_view.json", "run.json"}) {
    const std::string good = Slurp(folder_ / ("run/" + file));
    for (const std::string bad : {"[]", "{}", "7", "{\"ours_60\": \"seven\"}", "{"}) {
      Spill(folder_ / ("run/" + file), bad);
      Expect({"report", "-m", "$/run"}, {"$/run/" + file});
    }
    Spill(folder_ / ("run/" + file), good);
  }
  Spill(folder_ / "run/test/ours_60/renders/00001.png", "no image");
  Expect({"metrics", "-m", "$/run"}, {"$/run/test/ours_60/renders/00001.png"});
  fs::remove_all(folder_ / "run/test");
  Expect({"metrics", "-m", "$/run"}, {"$/run"});
  Expect({"report", "-m", "$/run"}, {"$/run"});
  Spill(folder_ / "run/results.json", "{\"ours_60\": 3}");
  Expect({"info", "$/run"}, {"$/run/results.json", "ours_60", "3"});
}

}  // namespace
}  // namespace cosplat::test

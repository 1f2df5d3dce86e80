// Scenes, images, settings and checkpoints.
#include <CLI/CLI.hpp>
#include <memory>

#include "apps/cosplat/options/avatar_options.h"
#include "apps/cosplat/options/command_line.h"
#include "apps/study/runs/study_list.h"
#include "splat/base/compression.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/state_file.h"
#include "splat/eval/lpips.h"
#include "splat/io/cameras_json.h"
#include "splat/io/colmap_model.h"
#include "splat/io/dataset.h"
#include "splat/media/image_io.h"
#include "splat/train/subject/scene_subject.h"
#include "tests/fuzz/reader.h"
#include "tests/splat/scene_fixture.h"
#include "tests/splat/training_fixture.h"
#include "tests/study/good_study_list.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_onnx.h"

namespace cosplat::test {
namespace {

using Strings = std::vector<std::string>;

// Scenes.

std::string ColmapProblem(const ColmapModel& model) {
  if (model.points.size() != model.point_colors.size()) return "points without colours";
  for (const ColmapImage& image : model.images)
    if (model.cameras.count(image.camera_id) == 0) return "an image without a camera";
  return NotFinite(model.points);
}

std::string ReadColmap(const std::string& folder, const std::string&) {
  return ColmapProblem(ReadColmapModel(folder));
}

Strings ColmapBinarySeeds() {
  ColmapFixture fixture;
  fixture.params = {150, 150, 80, 60};
  return {JoinParts({CamerasBin(fixture), ImagesBin(fixture), PointsBin()})};
}

Strings ColmapTextSeeds() {
  return {JoinParts({"# comment\n7 PINHOLE 160 120 150 150 80 60\n",
                     "# comment\n1 1 0 0 0 0.1 0.2 3 7 a b.png\r\n1.0 2.0 -1\n"
                     "2 1 0 0 0 0.1 0.2 3 7 c.png\n\n",
                     "# c\n5 0.35 -0.2 0.1 10 20 30 0.5 1 0\n6 1.35 0.8 1.1 10 20 31 0.5\n"})};
}

std::string ReadScene(const std::string& folder, const std::string&) {
  const SceneData scene = LoadScene(folder, {});
  for (const auto* views : {&scene.train, &scene.test})
    for (const SceneView& view : *views)
      if (const std::string problem =
              NotFinite(view.camera.rotation) + NotFinite(view.camera.translation);
          !problem.empty())
        return problem;
  return NotFinite(scene.points) + (scene.extent > 0 ? "" : "no extent");
}

void WriteSceneImages(const std::string& folder) {
  for (const char* name : {"/1.png", "/2.png"}) WriteImage(folder + name, Image8(16, 12, 3, 7));
}

constexpr const char* kMatrix = "[[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]]";

Strings NerfstudioSeeds() {
  std::string frames;
  for (const char* name : {"1.png", "2.png"})
    frames += std::string(frames.empty() ? "" : ",") + R"({"file_path": ")" + name +
              R"(", "transform_matrix": )" + kMatrix + "}";
  return {R"({"fl_x": 15, "fl_y": 14, "cx": 8, "cy": 6, "w": 16, "h": 12, "k1": 0.1, "p1": 0,
            "camera_model": "OPENCV", "frames": [)" +
          frames + "]}"};
}

Strings BlenderSeeds() {
  const auto part = [](const char* name) {
    return std::string(R"({"camera_angle_x": 0.7, "frames": [{"file_path": "./)") + name +
           R"(", "transform_matrix": )" + kMatrix + "}]}";
  };
  return {JoinParts({part("1"), part("2")})};
}

Strings CameraSeeds() {
  const TemporaryFolder folder;
  Camera camera;
  camera.width = 16, camera.height = 12;
  camera.fx = camera.fy = 15;
  WriteCamerasJson(folder / "cameras.json", {{"a", camera}, {"b", camera}});
  return {Slurped(folder / "cameras.json")};
}

std::string ReadCameras(const std::string& folder, const std::string&) {
  for (const NamedCamera& c : ReadCamerasJson(folder + "/cameras.json"))
    if (!NotFinite(c.camera.rotation).empty()) return "a camera that is not finite";
  return "";
}

// Images.

std::string ReadAnyImage(const std::string& folder, const std::string&) {
  const ImageInfo info = ReadImageInfo(folder + "/image");
  const Image8 image = ReadImage(folder + "/image");
  return image.empty() || info.width < 1 ? "an empty image" : "";
}

Strings ImageSeeds() {
  Strings seeds;
  for (int channels : {1, 3, 4})
    for (const char* name : {"a.png", "a.jpg"}) {
      if (channels == 4 && name[2] == 'j') continue;
      const std::vector<uint8_t> bytes = EncodeImage(name, Image8(9, 7, channels, 90));
      seeds.emplace_back(bytes.begin(), bytes.end());
    }
  return seeds;
}

// Settings.

std::string ReadStudy(const std::string& folder, const std::string&) {
  for (const StudyRun& run : ReadStudyList(folder + "/list.json"))
    if (run.Command().empty()) return "a run without a command";
  return "";
}

// The command line of a training with --config.
struct ConfiguredCommand {
  CLI::App app;
  CLI::App* command = nullptr;
  AvatarOptions options;

  ConfiguredCommand() {
    app.option_defaults()->always_capture_default();
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.fallthrough();
    AddConfig(app);
    command = app.add_subcommand("train-avatar");
    options.Declare(*command);
  }
  // In CLI11's order: the last argument first.
  void Parse(Strings reversed) {
    reversed.insert(reversed.end(), {"head.npz", "--flame", "out", "-m", "video", "-s"});
    reversed.push_back("train-avatar");
    app.parse(std::move(reversed));
    options.Settle(*command);
  }
};

std::string ReadConfig(const std::string& folder, const std::string&) {
  static ConfiguredCommand parsed;  // declaring its options takes ten times as long as reading
  try {
    parsed.Parse({folder + "/config.ini", "--config"});
  } catch (const CLI::ParseError& error) {
    throw Error("config.ini", error.what());
  }
  return "";
}

Strings ConfigSeeds() {
  ConfiguredCommand parsed;
  parsed.Parse({"0.5", "--lambda_dssim"});
  return {ConfigOf(parsed.app, *parsed.command), "[train-avatar]\niterations=5\neval=true\n"};
}

// Checkpoints: a scene's training of ten steps.

struct SmallRun {
  SceneSubject subject{TargetImages(TrueScene(1), Ring(2, 2.2f)), 1};
  Trainer trainer{ShortRun(10, 1), subject, FirstGaussians(12, 1)};
};

std::string ReadCheckpoint(const std::string& folder, const std::string&) {
  static SmallRun run;
  StateFile(folder + "/checkpoint.bin").Read([&](StateArchive& a) { run.trainer.Serialize(a); });
  return "";
}

Strings CheckpointSeeds() {
  const TemporaryFolder folder;
  SmallRun run;
  while (run.trainer.iteration() < 5) run.trainer.Step();
  WriteStateFile(
      folder / "checkpoint.bin", "a run", [&](StateArchive& a) { run.trainer.Serialize(a); });
  return {Slurped(folder / "checkpoint.bin")};
}

std::string ReadAnyJson(const std::string& folder, const std::string&) {
  const Json json = ReadJson(folder + "/a.json");
  const JsonField field("a.json", json);
  if (field.raw().is_array() && field.size() > 0) field.Numbers();
  if (field.raw().is_object() && field.Has("a")) field["a"].Integer();
  return "";
}

// A network of LPIPS with its weights.
Strings LpipsSeeds() {
  const TemporaryFolder folder;
  WriteReluLpips(folder.path(), "net");
  Strings parts;
  for (const char* name : {"net_backbone.onnx", "net_taps.txt", "net_lin.npz"})
    parts.push_back(Slurped(folder / name));
  return {JoinParts(parts)};
}

std::string ReadLpips(const std::string& folder, const std::string&) {
  return Lpips(folder).min_side() > 0 ? "" : "no image is large enough";
}

}  // namespace

std::vector<FuzzedReader> RunReaders() {
  const auto files = Placing::kFiles;
  const Strings transforms = {"transform_matrix",
                              "camera_angle_x",
                              "fl_x",
                              "camera_model",
                              "OPENCV_FISHEYE",
                              "mask_path",
                              "file_path",
                              "ply_file_path",
                              "1.png",
                              "null",
                              "1e999",
                              "-1"};
  return {
      {"colmap_binary",
       files,
       {"cameras.bin", "images.bin", "points3D.bin"},
       ReadColmap,
       ColmapBinarySeeds,
       {"\xff\xff\xff\xff\xff\xff\xff\xff", std::string(8, '\0')}},
      {"colmap_text",
       files,
       {"cameras.txt", "images.txt", "points3D.txt"},
       ReadColmap,
       ColmapTextSeeds,
       {"PINHOLE", "OPENCV", "SIMPLE_RADIAL", "FULL_OPENCV", "nan", "1e999", "#"}},
      {"nerfstudio",
       files,
       {"transforms.json"},
       ReadScene,
       NerfstudioSeeds,
       transforms,
       WriteSceneImages},
      {"blender",
       files,
       {"transforms_train.json", "transforms_test.json"},
       ReadScene,
       BlenderSeeds,
       transforms,
       WriteSceneImages},
      {"cameras_json",
       files,
       {"cameras.json"},
       ReadCameras,
       CameraSeeds,
       {"position", "rotation", "img_name", "width", "1e999", "null"}},
      {"image",
       files,
       {"image"},
       ReadAnyImage,
       ImageSeeds,
       {"\x89PNG\r\n\x1a\n",
        "IHDR",
        "IDAT",
        "IEND",
        "tRNS",
        "PLTE",
        "\xff\xd8\xff",
        "\xff\xc0",
        "\xff\xda",
        "Exif",
        "eXIf",
        "BM",
        "RIFF",
        "WEBPVP8L",
        "II*",
        "P6\n"}},
      {"lpips",
       files,
       {"net_backbone.onnx", "net_taps.txt", "net_lin.npz"},
       ReadLpips,
       LpipsSeeds,
       {"Conv", "Relu", "MaxPool", "Concat", "pads", "kernel_shape", "dilations", "group", "w0"}},
      {"study_list",
       files,
       {"list.json"},
       ReadStudy,
       [] { return Strings{kGoodStudyList}; },
       {"defaults", "{count}", "{value}", "values", "counts", "make_head", "minus", "seeds"}},
      {"config",
       files,
       {"config.ini"},
       ReadConfig,
       ConfigSeeds,
       {"[train-avatar]\n", "iterations=", "[", "]", "\"", "=", "preset=", "basis=", "%%", ";"}},
      {"checkpoint",
       Placing::kChecksummed,
       {"checkpoint.bin"},
       ReadCheckpoint,
       CheckpointSeeds,
       {"COSPLAT\n", "header", ".count"}},
      {"json",
       files,
       {"a.json"},
       ReadAnyJson,
       [] {
         return Strings{R"({"a": 1, "b": [NaN, -Infinity, null, "x\u0041"]})", "[1, [2, 3]]"};
       },
       {"NaN", "Infinity", "\\ud800", "1e999", "[[[[[[[[", "null", "\xef\xbb\xbf"}}};
}

}  // namespace cosplat::test

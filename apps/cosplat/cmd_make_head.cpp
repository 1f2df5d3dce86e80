// cosplat make-head: writes the procedural head's tracked video and its model file, or pictures of
// what our own head can do (--sheets).
#include <cstdio>
#include <memory>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/progress_bar.h"
#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "assets/head/video.h"
#include "avatar/model/blendshape_map.h"
#include "flame/pose.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/rng.h"
#include "splat/eval/metrics.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr int kSide = 160;  // px, of a tile
constexpr float kZoom = 1.2f, kLower = 0.12f;
constexpr size_t kColumns = 13, kPeople = 24;
constexpr uint64_t kSeed = 1;  // of the people

// faces: parameters, with their own shape.
Image8 SheetOf(const ProceduralHead& head, const std::vector<FlameParams>& faces) {
  Camera camera = procedural::OrbitCamera(0.35f, 0.05f, 0.75f, kSide);
  camera.fx *= kZoom;
  camera.fy *= kZoom;
  camera.cy += kLower * kSide;  // the head in the middle instead of its neck
  const int rows = int((faces.size() + kColumns - 1) / kColumns);
  Image8 sheet(kSide * int(kColumns), kSide * rows, 3, 255);
  for (size_t i = 0; i < faces.size(); ++i) {
    const FlamePoser<float> poser(head.model, faces[i].shape);
    std::vector<float> vertices;
    poser.Forward(FlamePoser<float>::ParametersOf(faces[i]), vertices);
    const Image8 tile = RenderProceduralHead(head, vertices, faces[i], camera);
    Paste(OverBackground(tile, {1, 1, 1}),
          kSide * int(i % kColumns),
          kSide * int(i / kColumns),
          sheet);
  }
  return sheet;
}

// Tiles in rows: expressions.png, each of ARKit's blendshapes (kArkitNames, in this order) at 1,
// mouthClose over an open jaw; shapes.png, each direction of shape at -2 and at 2; people.png, 24
// heads of random shape.
void WriteHeadSheets(const std::string& folder) {
  const ProceduralHead head = MakeHeadForPeopleParts();
  const BlendshapeMap map = GeneralBlendshapeMap(&head.model);
  std::vector<FlameParams> expressions, shapes, people(kPeople);
  for (const std::string_view name : kArkitNames) {
    BlendshapeScores scores{{std::string(name), 1.0f}};
    if (name == "mouthClose") scores["jawOpen"] = 1;
    ApplyBlendshapes(map, scores, expressions.emplace_back());
  }
  for (size_t k = 0; k < size_t(head.model.shape_count); ++k)
    for (const float amount : {-2.0f, 2.0f}) {
      shapes.emplace_back().shape.resize(k + 1);
      shapes.back().shape[k] = amount;
    }
  Rng rng{kSeed};
  for (FlameParams& person : people)
    for (int k = 0; k < head.model.shape_count; ++k) person.shape.push_back(float(rng.Normal()));
  MakeDirectories(folder);
  WriteImage(folder + "/expressions.png", SheetOf(head, expressions));
  WriteImage(folder + "/shapes.png", SheetOf(head, shapes));
  WriteImage(folder + "/people.png", SheetOf(head, people));
}

struct MakeHeadChoices : MakeHeadOptions {
  std::string out, sheets;
  bool quiet = false;
};

void MakeHead(const MakeHeadChoices& o) {
  if (!o.sheets.empty()) return WriteHeadSheets(o.sheets);
  if (o.out.empty()) throw Error("--out", "is missing: the folder to write");
  {
    ProgressBar bar("make-head", o.frames, o.quiet);
    WriteProceduralVideo(o.out, o, [&](int done, int) { bar.Update(done, "frames"); });
  }
  if (!o.quiet)
    std::printf("%d frames of %dx%d, the last %d held out: %s (model: %s/model.npz)\n",
                o.frames,
                o.size,
                o.size,
                o.test_frames,
                o.out.c_str(),
                o.out.c_str());
}

}  // namespace

void AddMakeHead(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("make-head", "render the procedural head: a tracked video to train on");
  const auto o = std::make_shared<MakeHeadChoices>();
  command->add_option("-o,--out", o->out, "folder to write");
  command->add_option("--frames", o->frames, "length of the video");
  command->add_option("--test-frames", o->test_frames, "the last ones, with unseen expressions");
  command->add_option("--size", o->size, "width and height in pixels");
  command->add_flag(
      "--frontal",
      o->frontal,
      "the head hardly turns, before one camera at rest; test frames are seen from all "
      "around");
  command->add_option("--seed", o->seed, "of the motion");
  command
      ->add_option(
          "--landmark-noise", o->landmark_noise, "px, added to the points in landmarks.json")
      ->check(CLI::Range(0.0, 100.0));
  const std::vector<CLI::Option*> of_video = command->get_options([&](const CLI::Option* option) {
    return option != command->get_help_ptr() && option != command->get_help_all_ptr();
  });
  auto* sheets = command->add_option(
      "--sheets", o->sheets, "folder for pictures of the expressions and shapes of our own head");
  for (CLI::Option* option : of_video) sheets->excludes(option);
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { MakeHead(*o); });
}

}  // namespace cosplat

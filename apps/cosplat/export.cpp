// cosplat export: a model's splats as files for other programs and for storage.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/export_measure.h"
#include "apps/cosplat/progress_bar.h"
#include "apps/cosplat/run_data.h"
#include "apps/cosplat/run_folder.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/ply.h"
#include "splat/io/scene_glb.h"
#include "splat/io/splat_file.h"
#include "splat/vq.h"

namespace cosplat {
namespace {

constexpr int kStandardDegree = 3;  // of KHR_gaussian_splatting

struct Options {
  std::string model, splats, source;
  std::string vq, ply, glb;
  VqSettings settings;
  bool truncate_degree = false;
  bool measure = false;
  bool quiet = false;
};

// What is exported, and where it comes from.
struct Subject {
  std::string path;  // of its splats
  Gaussians gaussians;
  bool is_avatar = false;
  // With a model folder and where views are needed:
  SceneData scene;
  std::array<float, 3> background{};
};

void Check(const Options& o) {
  if (o.vq.empty() && o.ply.empty() && o.glb.empty())
    throw Error("", "--vq, --ply, --glb", "none is given: at least one file must be written");
  if (o.model.empty() && o.splats.empty())
    throw Error("", "-m", "or --splats is needed: what is to be exported");
  if (o.measure && (o.vq.empty() || o.model.empty() || !o.splats.empty()))
    throw Error("", "--measure", "compares a model's PLY with its --vq: give -m and --vq only");
}

Subject Load(const Options& o) {
  Subject subject;
  subject.path = o.splats;
  if (o.model.empty()) {
    subject.gaussians = ReadSplats(o.splats);
    return subject;
  }
  const Json json = ReadRun(o.model);
  const JsonField run(o.model + "/run.json", json);
  subject.is_avatar = run["kind"].String() == "avatar";
  if (subject.is_avatar && !(o.vq.empty() && o.glb.empty()))
    throw Error(o.model,
                o.vq.empty() ? "--glb" : "--vq",
                "is for scenes; an avatar is in avatar.glb, which shows it at rest");
  if (o.splats.empty()) subject.path = SplatPath(o.model, SavedIteration(o.model, run));
  subject.gaussians = ReadSplats(subject.path);
  if (!o.vq.empty()) {
    const std::string source = o.source.empty() ? run["source"].String() : o.source;
    subject.scene = LoadSplitScene(source, SplitFromJson(run));
    subject.background = BackgroundOf(run);
  }
  return subject;
}

void Say(const Options& o, const std::string& path, const Subject& subject) {
  if (o.quiet) return;
  std::printf("%s: %s splats, %.2f MB%s\n",
              path.c_str(),
              WithThousands(subject.gaussians.size()).c_str(),
              double(std::filesystem::file_size(path)) / 1e6,
              subject.is_avatar ? ", the avatar at rest" : "");
}

void WriteQuantised(const Options& o, const Subject& subject) {
  ProgressBar bar("export", 2, o.quiet);
  bar.Update(0, "codebook");
  const QuantisedSplats splats =
      Quantise(subject.gaussians, SizeSignificance(subject.gaussians), o.settings);
  bar.Update(1, "file");
  WriteVqFile(o.vq, splats);
}

double MeanDegree(const QuantisedSplats& splats) {
  double sum = 0;
  for (const uint8_t degree : splats.own_degree) sum += degree;
  return splats.size() == 0 ? 0 : sum / double(splats.size());
}

// PSNR of the PLY and of the quantised file, both read back; into export.json, too.
void Measure(const Options& o, const Subject& subject) {
  FileFigures ply, vq;
  {
    int done = 0;
    ProgressBar bar("measure", 2 * int(subject.scene.test.size()), o.quiet);
    const auto measure = [&](const std::string& path) {
      return MeasureFile(
          path, subject.scene, subject.background, [&] { bar.Update(++done, "views"); });
    };
    ply = measure(subject.path);
    vq = measure(o.vq);
  }
  const Json json{{"gaussians", subject.gaussians.size()},
                  {"mean_degree", MeanDegree(ReadVqFile(o.vq))},
                  {"codebook", o.settings.codebook},
                  {"keep", o.settings.keep},
                  {"seed", o.settings.seed},
                  {"ply_mb", ply.mb},
                  {"ply_psnr", ply.psnr},
                  {"ply_ssim", ply.ssim},
                  {"vq_mb", vq.mb},
                  {"vq_psnr", vq.psnr},
                  {"vq_ssim", vq.ssim}};
  WriteFileAtomically(o.model + "/export.json", json.dump(2) + "\n");
  if (o.quiet) return;
  std::printf("PLY        %s\n", ToString(ply).c_str());
  std::printf("quantised  %s\n", ToString(vq).c_str());
}

void Export(const Options& o) {
  Check(o);
  const Subject subject = Load(o);
  if (o.measure && subject.scene.test.empty())
    throw Error(o.model, "--measure", "the run holds no views out: train with --eval");
  if (!o.glb.empty() && subject.gaussians.degree > kStandardDegree && !o.truncate_degree)
    throw Error(o.glb,
                "degree",
                "is 4, which standard glTF files do not hold: give --truncate-degree to leave band "
                "4 out");
  if (!o.ply.empty()) {
    WritePly(o.ply, subject.gaussians);
    Say(o, o.ply, subject);
  }
  if (!o.glb.empty()) {
    WriteSceneGlb(o.glb, subject.gaussians, o.truncate_degree);
    Say(o, o.glb, subject);
  }
  if (!o.vq.empty()) {
    WriteQuantised(o, subject);
    Say(o, o.vq, subject);
  }
  if (o.measure) Measure(o, subject);
}

}  // namespace

void AddExport(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("export", "write a model's splats as .ply, .glb or quantised");
  const auto o = std::make_shared<Options>();
  command->add_option("-m,--model_path", o->model, "a trained model's folder");
  command->add_option(
      "--splats", o->splats, "a PLY or quantised file; in place of the model's own with -m");
  command->add_option("-s,--source_path", o->source, "data set; the one trained on if not given");
  command->add_option("--ply", o->ply, "write 3DGS's PLY; of an avatar, at rest");
  command->add_option("--glb", o->glb, "write glTF with KHR_gaussian_splatting");
  command->add_flag("--truncate-degree",
                    o->truncate_degree,
                    "leave band 4 out of the .glb, whose format ends at degree 3");
  command->add_option(
      "--vq",
      o->vq,
      "write with vector-quantised colours: a .zip that NumPy opens (docs/vq-file.md)");
  command->add_option("--codebook", o->settings.codebook, "colours in the codebook, at most")
      ->check(CLI::Range(1, 65536));
  command
      ->add_option("--keep",
                   o->settings.keep,
                   "share of the splats, the most significant, that keep their own colour")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--seed", o->settings.seed, "of the codebook");
  command->add_flag("--measure",
                    o->measure,
                    "render the test views from the PLY and from --vq as read back: export.json");
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Export(*o); });
}

}  // namespace cosplat

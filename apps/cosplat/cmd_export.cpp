// cosplat export: writes a model's splats as files for other programs and for storage.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/export_subject.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/web_page.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/io/ply.h"
#include "splat/io/splat_file.h"

namespace cosplat {
namespace {

struct ExportOptions {
  ExportSource source;
  std::string vq, ply, glb, run, html;
  VqSettings settings;
  bool truncate_degree = false;
  bool quiet = false;
};

void Check(const ExportOptions& o) {
  if (o.vq.empty() && o.ply.empty() && o.glb.empty() && o.run.empty() && o.html.empty())
    throw Error("--vq, --ply, --glb, --run, --html", "give at least one of them");
  if (o.source.model.empty() && o.source.splats.empty())
    throw Error("-m, --splats", "give at least one of them: the model to export");
  if (o.source.measure && (o.vq.empty() || o.source.model.empty() || !o.source.splats.empty()))
    throw Error("--measure", "compares a model's PLY with its --vq: give -m and --vq only");
}

void CheckGlb(const ExportOptions& o, const ExportSubject& subject) {
  const std::string& path = o.glb.empty() ? o.run : o.glb;
  if (!path.empty() && subject.gaussians().degree > kMaxSplatFileDegree && !o.truncate_degree)
    throw Error(
        path,
        "degree",
        "is 4, but standard glTF supports at most 3: pass --truncate-degree to omit band 4");
}

// `what`: appended for avatars only.
void Say(const ExportOptions& o,
         const std::string& path,
         const ExportSubject& subject,
         const char* what) {
  if (o.quiet) return;
  std::printf("%s: %s splats, %.2f MB%s\n",
              path.c_str(),
              WithThousands(subject.gaussians().size()).c_str(),
              double(std::filesystem::file_size(path)) / 1e6,
              subject.is_avatar() ? what : "");
}

void WriteQuantised(const ExportOptions& o, const ExportSubject& subject) {
  ProgressBar bar("export", 2, o.quiet);
  bar.Update(0, "codebook");
  const QuantisedSplats splats = subject.Quantised(o.settings);
  bar.Update(1, "file");
  WriteVqFile(o.vq, splats);
}

double MeanDegree(const QuantisedSplats& splats) {
  double sum = 0;
  for (const uint8_t degree : splats.own_degree) sum += degree;
  return splats.size() == 0 ? 0 : sum / double(splats.size());
}

// Measures the trained model and the quantised file, both read back; also writes export.json.
void MeasureBoth(const ExportOptions& o, ExportSubject& subject) {
  FileFigures ply, vq;
  {
    const TestViews trained = subject.AsTrained(), quantised = subject.FromFile(o.vq);
    int done = 0;
    ProgressBar bar("measure", int(trained.count + quantised.count), o.quiet);
    const auto count_view = [&] { bar.Update(++done, "views"); };
    ply = Measure(subject.path(), trained, count_view);
    vq = Measure(o.vq, quantised, count_view);
  }
  const Json json{{"gaussians", subject.gaussians().size()},
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
  WriteFileAtomically(o.source.model + "/export.json", json.dump(2) + "\n");
  if (o.quiet) return;
  std::printf("PLY        %s\n", ToString(ply).c_str());
  std::printf("quantised  %s\n", ToString(vq).c_str());
}

void WriteHtml(const ExportOptions& o) {
  const WebModel model =
      FindWebModel(o.source.splats.empty() ? o.source.model : o.source.splats, o.source.flame);
  WriteWebPage(o.html, model);
  if (o.quiet) return;
  std::printf("%s: a page with its player, %.2f MB%s\n",
              o.html.c_str(),
              double(std::filesystem::file_size(o.html)) / 1e6,
              model.avatar.empty() || model.flame_redistributable
                  ? ""
                  : "; it asks for the FLAME model, which may not be passed on");
}

void Export(ExportOptions& o) {
  Check(o);
  if (!o.html.empty()) WriteHtml(o);
  if (o.vq.empty() && o.ply.empty() && o.glb.empty() && o.run.empty()) return;
  o.source.quantise = !o.vq.empty();
  const std::unique_ptr<ExportSubject> subject = LoadExportSubject(o.source);
  CheckGlb(o, *subject);
  // First what may be refused.
  if (!o.run.empty()) {
    subject->WriteRun(o.run, o.truncate_degree);
    Say(o, o.run + "/avatar.glb", *subject, ", with the data set's held-out frames");
  }
  if (!o.glb.empty()) {
    subject->WriteGlb(o.glb, o.truncate_degree);
    Say(o, o.glb, *subject, ", the avatar");
  }
  if (!o.ply.empty()) {
    WritePly(o.ply, subject->gaussians());
    Say(o, o.ply, *subject, ", the avatar at rest");
  }
  if (!o.vq.empty()) {
    WriteQuantised(o, *subject);
    Say(o, o.vq, *subject, ", on the avatar's triangles");
  }
  if (o.source.measure) MeasureBoth(o, *subject);
}

}  // namespace

void AddExport(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("export", "write a model's splats as .ply, .glb or quantised");
  const auto o = std::make_shared<ExportOptions>();
  command->add_option("-m,--model_path", o->source.model, "a trained model's folder");
  command->add_option("--splats",
                      o->source.splats,
                      "a PLY or quantised file, or GaussianAvatars' point cloud; in place of the "
                      "model's own with -m");
  command->add_option(
      "-s,--source_path",
      o->source.data,
      "data set; the one trained on if not given. Of GaussianAvatars' point clouds, the "
      "subject, if flame_param.npz is not beside them");
  command->add_option(
      "--flame",
      o->source.flame,
      "FLAME model file, for GaussianAvatars' point clouds and to measure an avatar with; the one "
      "trained with if not given");
  command->add_option("--ply", o->ply, "write 3DGS's PLY; of an avatar, at rest");
  command->add_option(
      "--glb",
      o->glb,
      "write glTF with KHR_gaussian_splatting: a scene, or GaussianAvatars' point cloud "
      "as an avatar");
  command->add_option(
      "--run",
      o->run,
      "write GaussianAvatars' point cloud as a run's folder, for render, metrics and "
      "play; needs -s");
  command->add_option(
      "--html", o->html, "write one page that shows the model offline, in any browser");
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
                   "fraction of the most significant splats that keep their own colour")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--seed", o->settings.seed, "of the codebook");
  command->add_flag("--measure",
                    o->source.measure,
                    "render the test views as trained and from --vq as read back: export.json");
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Export(*o); });
}

}  // namespace cosplat

// cosplat export: writes a model's splats as files for other programs and for storage.
#include <array>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/export_subject.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/web_model.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"
#include "splat/eval/metrics.h"
#include "splat/io/ply.h"
#include "splat/io/sog.h"
#include "splat/io/splat_file.h"
#include "splat/io/spz.h"
#include "splat/levels/levels_file.h"
#include "splat/media/image_io.h"
#include "splat/render/rasterizer.h"

namespace cosplat {
namespace {

struct ExportOptions {
  ExportSource source;
  std::string ply, glb, run, spz, sog, levels, html;
  int spz_version = 3;
  SogSettings sog_settings;
  bool truncate_degree = false;
  bool quiet = false;
};

bool WritesSplats(const ExportOptions& o) {
  return !(o.ply.empty() && o.glb.empty() && o.run.empty() && o.spz.empty() && o.sog.empty() &&
           o.levels.empty());
}

void Check(const ExportOptions& o) {
  if (!WritesSplats(o) && o.html.empty())
    throw Error("--ply, --glb, --spz, --sog, --levels, --run, --html", "give at least one of them");
  if (o.source.model.empty() && o.source.splats.empty())
    throw Error("-m, --splats", "give at least one of them: the model to export");
  if (o.source.measure && (o.source.model.empty() || !o.source.splats.empty()))
    throw Error("--measure", "compares a model's PLY with the other files: give -m only");
  if (o.source.measure && o.glb.empty() && o.spz.empty() && o.sog.empty())
    throw Error("--measure", "give --glb, --spz or --sog: the files to compare with the PLY");
  const std::array<std::pair<const char*, const std::string*>, 4> files{
      {{".ply", &o.ply}, {".glb", &o.glb}, {".spz", &o.spz}, {".sog", &o.sog}}};
  for (const auto& [kind, path] : files)
    for (const auto& [ending, other] : files)
      if (other != path && LowerCase(*path).ends_with(ending))
        throw Error("--" + std::string(kind + 1) + " " + *path,
                    "ends in " + std::string(ending) + ", for which other programs would take it");
  for (const auto& [kind, path] : files)
    for (const char* ending : {".gltf", ".gz", ".zip"})
      if (LowerCase(*path).ends_with(ending))
        throw Error(
            "--" + std::string(kind + 1) + " " + *path,
            "ends in " + std::string(ending) + ", by which other programs would not know it");
  const std::string& model = o.source.model;
  for (const auto& [kind, path] : files) {
    if (path->empty() || model.empty()) continue;
    const std::string name = std::filesystem::path(*path).filename().string();
    const bool is_runs = IsInside(*path, model + "/point_cloud") || name == "input.ply" ||
                         name == "avatar.glb" || (name.ends_with(".json") && name != "meta.json");
    if (is_runs && IsInside(*path, model))
      throw Error("--" + std::string(kind + 1) + " " + *path,
                  "is a file of the run: choose another");
  }
}

// What files with at most three bands can hold of the subject.
void CheckDegree(const ExportOptions& o, const ExportSubject& subject) {
  for (const std::string& path : {o.glb, o.run, o.spz, o.sog})
    if (!path.empty() && subject.gaussians.degree > kMaxSplatFileDegree && !o.truncate_degree)
      throw Error(
          path,
          "degree",
          "is 4, but other programs support at most 3: pass --truncate-degree to omit band 4");
}

// 0 of what is no file, such as a pipe.
double BytesOf(const std::string& path) {
  std::error_code none;
  const auto size = std::filesystem::file_size(path, none);
  return none ? 0 : double(size);
}

// `what`: appended for avatars only.
void Say(const ExportOptions& o,
         const std::string& path,
         const ExportSubject& subject,
         const char* what) {
  if (o.quiet) return;
  std::printf("%s: %s splats, %.2f MB%s\n",
              path.c_str(),
              WithThousands(subject.gaussians.size()).c_str(),
              BytesOf(path) / 1e6,
              subject.is_avatar ? what : "");
  if (subject.gaussians.origin == WorldOrigin{}) return;
  std::printf("%s: coordinates are counted from %s%s\n",
              path.c_str(),
              ToString(subject.gaussians.origin).c_str(),
              path == o.spz ? ", which SPZ has no place for" : "");
}

struct FileFigures {
  double mb = 0;              // file size, 10^6 bytes
  double psnr = 0, ssim = 0;  // means over the views, on 8-bit images as in `metrics`
};

// Image quality of a file: the subject's test views rendered from it after reading it back.
// `count_view` is called after each view. Views that show nothing are in no mean (HasContent);
// throws Error if none shows anything.
FileFigures MeasureFile(const std::string& path,
                        const ExportSubject& subject,
                        const std::function<void()>& count_view) {
  FileFigures figures;
  figures.mb = double(std::filesystem::file_size(path)) / 1e6;
  const Gaussians gaussians = ReadSplats(path);
  const auto rasterizer = MakeCpuRasterizer();
  const auto tape = rasterizer->MakeTape();
  const RenderSettings settings{subject.background, gaussians.degree};
  int measured = 0;
  RenderedImage image;
  for (const SceneView& view : subject.data.test) {
    rasterizer->Forward(ViewOf(gaussians), gaussians.basis, view.camera, settings, image, *tape);
    const Image8 held_out = OverBackground(LoadViewImage(view), subject.background);
    count_view();
    if (!HasContent(held_out)) continue;
    const ImageMetrics m = CompareImages(ToBytes(image.ToImage()), held_out);
    figures.psnr += m.psnr;
    figures.ssim += m.ssim;
    ++measured;
  }
  if (measured == 0)
    throw Error("--measure", "there is nothing to compare: each test image is all of one colour");
  figures.psnr /= measured;
  figures.ssim /= measured;
  return figures;
}

// Measures the trained model and the files written from it, all read back; also writes export.json.
void MeasureFiles(const ExportOptions& o, const ExportSubject& subject) {
  struct File {
    std::string name, path;
  };
  const std::array<File, 4> all{
      File{"ply", subject.path}, File{"glb", o.glb}, File{"spz", o.spz}, File{"sog", o.sog}};
  std::vector<File> files;
  for (const File& file : all)
    if (!file.path.empty()) files.push_back(file);
  Json json{{"gaussians", subject.gaussians.size()}, {"seed", o.sog_settings.seed}};
  std::string lines;
  {
    ProgressBar bar("measure", int(files.size() * subject.data.test.size()), o.quiet);
    int done = 0;
    for (const File& file : files) {
      const FileFigures figures =
          MeasureFile(file.path, subject, [&] { bar.Update(++done, "views"); });
      json[file.name + "_mb"] = figures.mb;
      json[file.name + "_psnr"] = figures.psnr;
      json[file.name + "_ssim"] = figures.ssim;
      lines += Format("{}  {:.2f} MB  PSNR {:.2f} dB  SSIM {:.4f}\n",
                      file.name,
                      figures.mb,
                      figures.psnr,
                      figures.ssim);
    }
  }
  WriteFileAtomically(o.source.model + "/export.json", json.dump(2) + "\n");
  if (!o.quiet) std::printf("%s", lines.c_str());
}

// The files that store colours coarsely.
void WritePacked(const ExportOptions& o, const ExportSubject& subject) {
  if (o.spz.empty() && o.sog.empty()) return;
  Gaussians g = subject.gaussians;
  TruncateDegree(kMaxSplatFileDegree, g);
  SogSettings settings = o.sog_settings;
  settings.seen_bands = SeenBandsOf(subject);
  if (!o.spz.empty()) {
    WriteSpz(o.spz, g, settings.seen_bands, o.spz_version);
    Say(o, o.spz, subject, ", the avatar at rest");
  }
  if (!o.sog.empty()) {
    {
      ProgressBar bar("export", 2, o.quiet);
      bar.Update(0, "significance");
      const std::vector<float> significance = SignificanceOf(subject);
      bar.Update(1, "SOG");
      WriteSog(o.sog, g, significance, settings);
    }
    Say(o, o.sog, subject, ", the avatar at rest");
  }
}

// Takes the subject's Gaussians, of which there may be too many for a copy.
void WriteLevels(const ExportOptions& o, ExportSubject& subject) {
  const SceneLevels levels = BuildLevels(std::move(subject.gaussians));
  WriteLevels(o.levels, levels);
  if (!o.quiet)
    std::printf("%s: levels of detail of %s splats, %.2f MB\n",
                o.levels.c_str(),
                WithThousands(levels.size()).c_str(),
                double(std::filesystem::file_size(o.levels)) / 1e6);
}

void WriteHtml(const ExportOptions& o) {
  const WebModel model =
      FindWebModel(o.source.splats.empty() ? o.source.model : o.source.splats, o.source.flame);
  WriteWebPage(o.html, model);
  if (o.quiet) return;
  std::printf(
      "%s: a page with its player, %.2f MB%s\n",
      o.html.c_str(),
      double(std::filesystem::file_size(o.html)) / 1e6,
      model.flame.empty() ? "" : "; it asks for the FLAME model, which may not be passed on");
}

void Export(ExportOptions& o) {
  Check(o);
  if (!o.html.empty()) WriteHtml(o);
  if (!WritesSplats(o)) return;
  o.source.views = !o.sog.empty() || !o.spz.empty();
  ExportSubject subject = LoadExportSubject(o.source);
  CheckDegree(o, subject);
  // First what may be refused.
  if (!o.run.empty()) {
    ExportRun(o.run, o.source, subject, o.truncate_degree);
    Say(o, o.run + "/avatar.glb", subject, ", with the data set's held-out frames");
  }
  if (!o.glb.empty()) {
    ExportGlb(o.glb, subject, o.truncate_degree);
    Say(o, o.glb, subject, ", the avatar");
  }
  if (!o.ply.empty()) {
    WritePly(o.ply, subject.gaussians);
    Say(o, o.ply, subject, ", the avatar at rest");
  }
  WritePacked(o, subject);
  if (o.source.measure) MeasureFiles(o, subject);
  if (!o.levels.empty()) WriteLevels(o, subject);
}

}  // namespace

void AddExport(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "export", "write a model's splats as .ply, .glb, .spz or .sog, or levels of detail");
  const auto o = std::make_shared<ExportOptions>();
  command->add_option("-m,--model_path", o->source.model, "a trained model's folder");
  command->add_option(
      "--splats",
      o->source.splats,
      "a splat file of any layout that is read (docs/files.md), or GaussianAvatars' "
      "point cloud; in place of the model's own with -m");
  command->add_option(
      "-s,--source_path",
      o->source.data,
      "data set; the one trained on if not given. Of GaussianAvatars' point clouds, the "
      "subject, if flame_param.npz is not beside them");
  command->add_option("--flame",
                      o->source.flame,
                      "FLAME model file, for GaussianAvatars' point clouds and an avatar's page; "
                      "the one trained with "
                      "if not given");
  command->add_option("--ply", o->ply, "write 3DGS's PLY; of an avatar, at rest");
  command->add_option(
      "--glb",
      o->glb,
      "write glTF with KHR_gaussian_splatting: a scene, or GaussianAvatars' point cloud "
      "as an avatar");
  command->add_option("--levels",
                      o->levels,
                      "write levels of detail for `play`, which reads of them what it draws: for "
                      "scenes of millions of Gaussians; of an avatar, at rest");
  command->add_option("--spz", o->spz, "write Niantic's SPZ; of an avatar, at rest");
  command
      ->add_option("--spz-version",
                   o->spz_version,
                   "of the .spz: 2, 3 or 4; which programs read which is in docs/files.md")
      ->check(CLI::Range(2, 4));
  command->add_option("--sog",
                      o->sog,
                      "write PlayCanvas' SOG: a bundle, or into a folder if the name ends in "
                      "meta.json; of an avatar, at rest");
  command
      ->add_option("--sog-palette",
                   o->sog_settings.palette,
                   "colours of bands 1 and up in the .sog, at most")
      ->check(CLI::Range(1, 65536));
  command->add_option(
      "--run",
      o->run,
      "write GaussianAvatars' point cloud as a run's folder, for render, metrics and "
      "play; needs -s");
  command->add_option(
      "--html", o->html, "write one page that shows the model offline, in any browser");
  command->add_flag("--truncate-degree",
                    o->truncate_degree,
                    "leave band 4 out of the .glb, .spz and .sog, which end at degree 3");
  command->add_option("--seed", o->sog_settings.seed, "of the codebooks in the .sog");
  command->add_flag("--measure",
                    o->source.measure,
                    "render a scene's test views from the PLY and the other files: export.json");
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Export(*o); });
}

}  // namespace cosplat

// cosplat info: summarises a model, avatar, splat file or data set in a few lines.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/io/avatar_file.h"
#include "avatar/io/gaussian_avatars.h"
#include "flame/model.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/median.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"
#include "splat/io/dataset.h"
#include "splat/io/ply.h"
#include "splat/io/splat_file.h"
#include "splat/levels/levels_file.h"
#include "splat/train/density/bands.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

// Number of Gaussians of each per-Gaussian degree.
void DegreeInfo(Gaussians g) {
  FindDegrees(g);
  const DegreeCounts counts = CountDegrees(g);
  std::printf("own degrees:");
  for (int degree = 0; degree <= g.degree; ++degree)
    std::printf(" %s of %d,", WithThousands(counts[degree]).c_str(), degree);
  const DegreeFigures figures = FiguresOf(counts, g.degree);
  std::printf(" mean %.2f; %.0f %% of the coefficients of bands 1 and up are unused\n",
              figures.mean,
              100 * figures.rest_saved);
}

// "3DGS", "SPZ" and so on.
std::string LayoutName(const std::string& path, SplatLayout layout) {
  switch (layout) {
    case SplatLayout::kPly:
      return IsCompressedPly(path) ? "PlayCanvas compressed" : "3DGS";
    case SplatLayout::kSpz:
      return "SPZ";
    case SplatLayout::kSog:
      return "SOG";
    case SplatLayout::kRecords:
      return ".splat";
    case SplatLayout::kGlb:
      return "glTF";
    case SplatLayout::kNone:
      break;
  }
  return "";
}

void SplatInfo(const std::string& path, SplatLayout layout) {
  if (layout == SplatLayout::kPly && IsGaussianAvatarPly(path)) {
    std::printf("%s", SummarizeGaussianAvatar(path).c_str());
    return;
  }
  const Gaussians g = ReadSplatsAloud(path);
  std::printf("%s splats: %s Gaussians, SH degree %d\n",
              LayoutName(path, layout).c_str(),
              WithThousands(g.size()).c_str(),
              g.degree);
  if (g.degree > 0) DegreeInfo(g);
  if (g.antialiased)
    std::printf("anti-aliased, for a low-pass filter of %.1f px^2\n", g.low_pass_variance);
  if (g.origin != WorldOrigin{})
    std::printf("coordinates are counted from %s\n", ToString(g.origin).c_str());
  if (IsRoundedFarAway(g))
    std::printf("and were stored as 32-bit floats so far from zero: they are rounded\n");
  if (g.size() == 0) return;
  std::vector<float> opacity, scale;
  std::array<float, 3> low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
  for (size_t i = 0; i < g.size(); ++i) {
    opacity.push_back(1 / (1 + std::exp(-g.at(kOpacityLogit, i)[0])));
    scale.push_back(std::exp(*std::max_element(g.at(kScaleLog, i), g.at(kScaleLog, i) + 3)));
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], g.at(kPosition, i)[k]);
      high[k] = std::max(high[k], g.at(kPosition, i)[k]);
    }
  }
  std::printf("box: (%.3g, %.3g, %.3g) to (%.3g, %.3g, %.3g)\n",
              low[0],
              low[1],
              low[2],
              high[0],
              high[1],
              high[2]);
  std::printf("median opacity %.3f, median largest standard deviation %.3g\n",
              Median(opacity),
              Median(scale));
}

void FlameInfo(const std::string& path) {
  const FlameModel m = LoadFlameModel(path);
  std::printf("FLAME model: %d vertices, %zu faces, %d shape and %d expression directions\n",
              m.vertex_count,
              m.faces.size(),
              m.shape_count,
              m.expression_count);
  std::printf("%s", UnitLine("the model", m.unit).c_str());
  std::printf(
      "sha256 %s, %s\n",
      m.sha256.c_str(),
      m.redistributable ? "may be embedded in avatar files" : "not embedded in avatar files");
}

void TrackInfo(const std::string& path, bool need_images) {
  const TrackedVideo v = need_images ? LoadTrackedVideo(path, {}) : LoadDrivingSequence(path);
  PrintNotes(v.notes);
  const TrackedFrame& f = v.train.empty() ? v.test.at(0) : v.train[0];
  std::printf("tracked video (%s): %zu training and %zu test frames of %dx%d, %zu skipped\n",
              v.layout.c_str(),
              v.train.size(),
              v.test.size(),
              f.camera.width,
              f.camera.height,
              v.skipped.size());
  std::printf("%zu shape and %zu expression coefficients, focal length %.1f px\n",
              v.shape.size(),
              f.params.expression.size(),
              f.camera.fx);
  std::printf("%s", UnitLine("the track", v.unit).c_str());
}

// One line per evaluation.
std::string ResultLines(const std::string& path) {
  if (!fs::exists(path)) return "";
  const JsonField results(path, ReadJson(path));
  std::string lines;
  for (const auto& [name, figures] : results.raw().items()) {
    lines += name + ":";
    for (const auto& [figure, value] : figures.items()) {
      lines += Format(" {} {:.4f}", figure, results[name][figure].Number());
    }
    lines += "\n";
  }
  return lines;
}

// Savings and cost of dropping colour bands; empty if none were dropped.
std::string BandsLine(const std::string& path) {
  if (!fs::exists(path)) return "";
  const JsonField stats(path, ReadJson(path));
  if (stats.NumberOr("rest_saved", 0) == 0) return "";
  return Format(
      "bands dropped: mean degree {:.2f}, {:.0f} % of the coefficients of bands 1 and up; {:+.2f} "
      "dB on training images at the time\n",
      stats["mean_degree"].Number(),
      100 * stats["rest_saved"].Number(),
      stats["drop_psnr"].Number());
}

void RunInfo(const std::string& path) {
  const JsonField run = ReadRun(path);
  const std::string results = ResultLines(path + "/results.json");
  std::printf("trained %s: %d iterations, degree %d, basis %s, seed %s, of %s\n%s%s",
              run["kind"].String().c_str(),
              run["iterations"].Integer(),
              run["degree"].Integer(),
              run["basis"].String().c_str(),
              run["seed"].raw().dump().c_str(),
              run["source"].String().c_str(),
              BandsLine(path + "/stats.json").c_str(),
              results.c_str());
}

void SceneInfo(const std::string& path) {
  const SceneData s = LoadScene(path, {LargestResolution(path), true, false});
  std::printf("scene (%s): %zu training and %zu test views of %dx%d, %zu skipped\n",
              s.layout.c_str(),
              s.train.size(),
              s.test.size(),
              s.train.at(0).camera.width,
              s.train[0].camera.height,
              s.skipped.size());
  std::printf("%s points, extent %.3g\n", WithThousands(s.points.size() / 3).c_str(), s.extent);
  std::printf("%s", PlaceLines(s).c_str());
}

void FolderInfo(const std::string& path) {
  if (IsRun(path)) return RunInfo(path);
  if (IsRun(path + "/avatar")) return RunInfo(path + "/avatar");  // of `cosplat avatar`
  if (!TrackLayoutOf(path).empty()) return TrackInfo(path, true);
  SceneInfo(path);
}

void LevelsInfo(const std::string& path) {
  const SceneLevels levels = OpenLevels(path);
  std::printf("levels of detail: %s Gaussians, SH degree %d, %s blocks\n",
              WithThousands(levels.size()).c_str(),
              levels.layout.degree,
              WithThousands(levels.blocks.size()).c_str());
}

void Info(const std::string& path) {
  if (!fs::exists(path)) throw Error(path, "does not exist");
  const std::string extension = fs::path(path).extension().string();
  const SplatLayout layout = SplatLayoutOf(path);
  if (layout == SplatLayout::kGlb) {
    const GlbSummary summary = SummarizeGlb(path);
    std::printf("%s", ToString(summary).c_str());
    if (!summary.avatar) ReadSplatsAloud(path);  // for its notes
  } else if (layout != SplatLayout::kNone) {
    SplatInfo(path, layout);
  } else if (IsLevelsFile(path)) {
    LevelsInfo(path);
  } else if (fs::is_directory(path)) {
    FolderInfo(path);
  } else if (extension == ".pkl") {
    FlameInfo(path);
  } else if (extension == ".npz") {
    if (Npz::Read(path).Has("v_template")) {
      FlameInfo(path);
    } else {
      TrackInfo(path, false);
    }
  } else {
    const std::string other = OtherKindOf(path);
    throw Error(
        path, other.empty() ? "is not a splat file, a .glb, .pkl or .npz file or a folder" : other);
  }
}

}  // namespace

void AddInfo(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("info", "summarise a model, avatar, splat file or data set");
  const auto path = std::make_shared<std::string>();
  command->add_option("file", *path, "file or folder")->required();
  command->callback([path] { Info(*path); });
}

}  // namespace cosplat

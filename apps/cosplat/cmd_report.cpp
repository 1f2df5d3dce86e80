// cosplat report: one self-contained HTML page about a run: images, an animated preview, figures.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/charts/svg_chart.h"
#include "apps/charts/svg_drawing.h"
#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/html_page.h"
#include "apps/cosplat/run/run_folder.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

constexpr size_t kPairs = 4;           // renders next to their ground truth
constexpr size_t kPreviewFrames = 48;  // of the animated preview
constexpr int kPreviewWidth = 320;     // px

// The image as a JPEG data URI, at most `width` wide.
std::string Embed(const std::string& path, int width) {
  Image8 image = ReadImage(path);
  if (image.width > width)
    image = ResizeByArea(image, width, std::max(1, image.height * width / image.width));
  return ImageUri(image, ".jpg");
}

using NamedNumbers = std::vector<std::pair<std::string, double>>;

// Reads an object of finite numbers.
NamedNumbers NumbersIn(const JsonField& object) {
  NamedNumbers numbers;
  for (const auto& [name, value] : object.raw().items())
    numbers.push_back({name, object[name].Number()});
  return numbers;
}

// stats: of its training; null if there are none, as of a folder of 3DGS's own.
std::string FiguresTable(const NamedNumbers& results, const JsonField& stats) {
  std::vector<std::pair<std::string, std::string>> rows;
  const auto row = [&](const std::string& name, const std::string& value) {
    rows.push_back({name, value});
  };
  const std::vector<std::array<const char*, 3>> figures{
      {"PSNR", "PSNR, whole image", "{:.2f} dB"},
      {"PSNR_mask", "PSNR inside the mask", "{:.2f} dB"},
      {"PSNR_head", "PSNR of the head alone, above the chin", "{:.2f} dB"},
      {"PSNR_mouth", "PSNR of the mouth", "{:.2f} dB"},
      {"PSNR_highlight", "PSNR of the brightest 2 %", "{:.2f} dB"},
      {"SSIM", "SSIM", "{:.4f}"}};
  for (const auto& [key, name, format] : figures)
    for (const auto& [result, value] : results)
      if (result == key) row(name, Format(format, value));
  for (const auto& [result, value] : results)
    if (result.rfind("LPIPS_", 0) == 0)
      row("LPIPS (" + result.substr(6) + ")", Format("{:.4f}", value));
  if (stats.raw().is_null()) return HtmlTable(rows);
  row("Gaussians", WithThousands(size_t(stats["gaussians"].Number())));
  if (stats.NumberOr("rest_saved", 0) > 0) {
    row("Mean degree of the colours", Format("{:.2f}", stats["mean_degree"].Number()));
    row("Coefficients dropped", Format("{:.0f} %", 100 * stats["rest_saved"].Number()));
    row("PSNR in training as they were dropped", Format("{:+.2f} dB", stats["drop_psnr"].Number()));
  }
  row("Iterations", WithThousands(size_t(stats["iterations"].Number())));
  row("Training", Format("{:.0f} s", stats["seconds"].Number()));
  row("One step", Format("{:.1f} ms", stats["ms_per_step"].Number()));
  row("Memory at most", Format("{:.0f} MB", stats["peak_mb"].Number()));
  return HtmlTable(rows);
}

// Time per phase of a training step.
std::string PhaseChart(const NamedNumbers& phases) {
  Chart chart{Chart::Kind::kBars, "Where a step's time goes", {"time", "ms"}, {}, {}, {}};
  ChartSeries step{"step", {}};
  for (const auto& [name, ms] : phases) step.marks.push_back({ms, 0, name});
  chart.series = {step};
  return ToSvg(chart);
}

std::string ViewChart(const NamedNumbers& per_view) {
  Chart chart{Chart::Kind::kLines, "PSNR per view", {"test view", ""}, {"PSNR", "dB"}, {}, {}};
  ChartSeries views{"views", {}};
  for (const auto& [name, psnr] : per_view)
    views.marks.push_back({double(views.marks.size()), psnr, ""});
  chart.series = {views};
  return ToSvg(chart);
}

std::string PairsHtml(const std::string& test, const std::vector<std::string>& names) {
  std::string html = "<div class='pairs'>";
  for (const std::string& name : Spread(names, kPairs))
    html += "<figure><img src='" + Embed(test + "/renders/" + name, 512) +
            "'><figcaption>rendered, " + name + "</figcaption></figure><figure><img src='" +
            Embed(test + "/gt/" + name, 512) + "'><figcaption>held-out image</figcaption></figure>";
  return html + "</div>";
}

// What `metrics --turn` drew; empty if it did not.
std::string TurnedHtml(const std::string& path) {
  if (!fs::exists(path)) return "";
  return "<h2>From where it was not filmed</h2><img src='" + Embed(path, 1920) + "'>";
}

// Of the track that an avatar was trained on, if it is `cosplat track`'s.
std::vector<std::string> AdviceOf(const std::string& source) {
  const std::string path = source + "/track.json";
  if (!fs::exists(path)) return {};
  const JsonField track(path, ReadJson(path));
  std::vector<std::string> advice;
  for (size_t i = 0; track.Has("advice") && i < track["advice"].size(); ++i)
    advice.push_back(track["advice"][i].String());
  return advice;
}

std::string PreviewHtml(const std::string& test, const std::vector<std::string>& names) {
  std::string frames;
  for (const std::string& name : Spread(names, kPreviewFrames))
    frames +=
        (frames.empty() ? "\"" : ",\n\"") + Embed(test + "/renders/" + name, kPreviewWidth) + "\"";
  return "<img id='preview' width='" + std::to_string(kPreviewWidth) + "'><script>const frames=[" +
         frames +
         "];let i=0;const img=document.getElementById('preview');"
         "setInterval(()=>{img.src=frames[i++%frames.length]},80);img.src=frames[0];</script>";
}

}  // namespace

void WriteReport(const std::string& model, bool quiet) {
  const auto read = [&](const char* name) {
    return JsonField(model + name, ReadJson(model + name));
  };
  const JsonField run = ReadRun(model), all_results = read("/results.json"),
                  all_views = read("/per_view.json");
  const bool has_stats = fs::exists(model + "/stats.json");
  const JsonField stats = has_stats ? read("/stats.json") : JsonField("", Json());
  const int iteration = SavedIteration(model, run);
  const std::string test = model + "/test/ours_" + std::to_string(iteration);
  if (!fs::exists(test))
    throw Error(
        model, "test", "contains no images: train with --eval or run `cosplat render` first");
  const std::string key = fs::path(test).filename().string();
  const NamedNumbers results = NumbersIn(all_results[key]);
  const JsonField per_view = all_views[key];
  if (per_view.raw().empty())
    throw Error(model, "test", "each image is all of one colour, so that there is no figure");
  const NamedNumbers psnr = NumbersIn(per_view["PSNR"]);
  std::vector<std::string> names;
  for (const auto& [name, value] : psnr) names.push_back(name);
  const bool avatar = run["kind"].String() == "avatar";
  const std::string title = avatar ? "Head avatar" : "Scene";
  const std::string body =
      "<h1>" + title + " trained on " + EscapeXml(run["source"].String()) +
      "</h1><div class='row'><div>" + PreviewHtml(test, names) +
      "</div><div><h2>Held-out views</h2>" + FiguresTable(results, stats) + "</div></div>" +
      AdviceHtml(AdviceOf(run["source"].String())) + "<h2>Rendered beside what was held out</h2>" +
      PairsHtml(test, names) + TurnedHtml(model + "/turned.png") + "<div class='row'>" +
      ViewChart(psnr) + (has_stats ? PhaseChart(NumbersIn(stats["phases_ms"])) : "") +
      "</div><h2>Settings</h2><pre>" + EscapeXml(run.raw().dump(2)) + "</pre>";
  WriteFileAtomically(model + "/report.html", HtmlPage(title, body));
  if (!quiet) std::printf("report: %s/report.html\n", model.c_str());
}

void AddReport(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("report", "one HTML page about a trained model: images and figures");
  const auto model = std::make_shared<std::string>();
  const auto quiet = std::make_shared<bool>(false);
  command->add_option("-m,--model_path", *model, "a trained model's folder")->required();
  command->add_flag("--quiet", *quiet, "print nothing but errors");
  command->callback([=] { WriteReport(*model, *quiet); });
}

}  // namespace cosplat

#include <algorithm>
#include <array>

#include "apps/charts/svg_chart.h"
#include "apps/charts/svg_drawing.h"
#include "apps/cosplat/run/frame_sink.h"
#include "apps/cosplat/run/html_page.h"
#include "apps/cosplat/run/overlay.h"
#include "apps/cosplat/run/progress_bar.h"
#include "apps/cosplat/run/run_folder.h"
#include "apps/cosplat/run/track_run.h"
#include "flame/eyelids.h"
#include "flame/pose.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr size_t kOverlays = 12;
constexpr std::array<uint8_t, 3> kSeenColor{60, 230, 90}, kFittedColor{240, 60, 50};

std::vector<float> VerticesOf(const TrackRun& run, size_t f) {
  FlameParams params = run.fit.frames[f]->params;
  EyelidsToExpression(run.model, params);
  std::vector<float> vertices;
  FlamePoser<float>(run.model, run.fit.shape, run.fit.static_offset)
      .Forward(FlamePoser<float>::ParametersOf(params), vertices);
  return vertices;
}

// The share of a frame's numbers, sorted.
double Percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[size_t(share * double(values.size() - 1))];
}

std::vector<double> ErrorsOf(const TrackRun& run) {
  std::vector<double> errors;
  for (size_t f : run.kept) errors.push_back(run.fit.frames[f]->error);
  return errors;
}

Json FiguresOf(const TrackRunOptions& o, const TrackRun& run) {
  Json frames = Json::array();
  for (size_t f : run.kept)
    frames.push_back({{"name", run.marks.frames[f].name},
                      {"error_px", run.fit.frames[f]->error},
                      {"turned_degrees", run.fit.frames[f]->turned}});
  return {{"source", o.source},
          {"landmarks", o.landmarks},
          {"flame", o.flame},
          {"focal_px", run.whole_camera().fx},
          {"focal_given", o.focal > 0},
          {"error_px", run.fit.error},
          {"error_px_95", Percentile(ErrorsOf(run), 0.95)},
          {"brightness_spread", run.fit.brightness_spread},
          {"held_out_psnr", run.held_out_psnr},
          {"cuts", run.chosen.cuts},
          {"advice", run.advice},
          {"frames", frames}};
}

std::string ErrorChart(const TrackRun& run) {
  Chart chart{Chart::Kind::kLines,
              "Distance from the landmarks",
              {"frame", ""},
              {"mean distance", "px"},
              {},
              {}};
  ChartSeries errors{"frames", {}};
  for (size_t f : run.kept)
    errors.marks.push_back({double(run.marks.frames[f].frame), run.fit.frames[f]->error, ""});
  chart.series = {errors};
  return ToSvg(chart);
}

// By the landmarks alone, and after the last round of refinement.
std::string SpreadText(const std::vector<double>& spread) {
  return Format("{:.2f}", spread.front()) + " before, " + Format("{:.2f}", spread.back()) +
         " after " + std::to_string(spread.size() - 1) + " rounds";
}

std::string FiguresHtml(const TrackRunOptions& o, const TrackRun& run) {
  const auto px = [](double value) { return Format("{:.2f} px", value); };
  return HtmlTable(
      {{"Frames tracked", Format("{} of {}", run.kept.size(), run.fit.frames.size())},
       {"Distance from the landmarks, mean", px(run.fit.error)},
       {"95 % of the frames are below", px(Percentile(ErrorsOf(run), 0.95))},
       {"Points differ in brightness from frame to frame by (of 255), refining by the images",
        SpreadText(run.fit.brightness_spread)},
       {"Refining by avatars", AvatarRoundsText(run.held_out_psnr)},
       {"Landmarks used", std::to_string(run.embedding.size()) + " of " + NameOf(run.marks.set)},
       {o.focal > 0 ? "Focal length, as given" : "Focal length, found",
        Format("{:.0f} px", run.whole_camera().fx)},
       {"Cuts, or changes to another face", std::to_string(run.chosen.cuts)}});
}

std::string OverlaysHtml(const TrackRun& run, const FrameSource& frames) {
  std::string html;
  for (const size_t f : Spread(run.kept, kOverlays)) {
    html += FigureHtml(DrawOverlay(run, f, frames.Read(run.marks.frames[f].frame)),
                       run.marks.frames[f].name + Format(": {:.2f} px", run.fit.frames[f]->error));
  }
  return html;
}

std::string SkippedHtml(const TrackRun& run) {
  if (run.skipped.empty()) return "";
  std::vector<std::pair<std::string, std::string>> rows;
  for (const auto& [name, reason] : run.skipped) rows.push_back({name, reason});
  return "<h2>Frames that are left out</h2>" + HtmlTable(rows);
}

void WriteOverlays(const TrackRunOptions& o, const TrackRun& run, const FrameSource& frames) {
  FrameSink sink(o.overlay);
  ProgressBar bar("overlay", int(run.kept.size()), o.quiet);
  for (size_t f : run.kept) {
    sink.Write(DrawOverlay(run, f, frames.ReadWhole(run.marks.frames[f].frame)));
    bar.Update(sink.count(), "frames");
  }
  sink.Finish();
}

}  // namespace

Image8 DrawOverlay(const TrackRun& run, size_t f, const Image8& image) {
  const bool whole = run.marks.crop && image.width != run.marks.width;
  Image8 overlay = MeshOver(
      VerticesOf(run, f), run.model.faces, whole ? run.whole_camera() : run.fit.camera, image);
  const FittedFrame& frame = *run.fit.frames[f];
  const auto dot = [&](const std::array<double, 2>& point, const auto& color) {
    const auto [x, y] = whole ? run.marks.crop->InFrame(point) : point;
    DrawDot(x, y, color, overlay);
  };
  for (size_t p = 0; p < run.embedding.size(); ++p) {
    dot(run.chosen.faces[f]->points[size_t(run.embedding[p].landmark)], kSeenColor);
    dot(frame.points[p], kFittedColor);
  }
  return overlay;
}

void WriteTrackReport(const TrackRunOptions& o, const TrackRun& run, const FrameSource& frames) {
  WriteFileAtomically(o.out + "/track.json", FiguresOf(o, run).dump(1) + "\n");
  const std::string body = "<h1>Track of " + EscapeXml(o.source) + "</h1><div class='row'><div>" +
                           FiguresHtml(o, run) + "</div>" + ErrorChart(run) + "</div>" +
                           AdviceHtml(run.advice) +
                           "<h2>The mesh over the video</h2><p>Landmarks as seen are green, "
                           "as the mesh has them red.</p><div class='many'>" +
                           OverlaysHtml(run, frames) + "</div>" + SkippedHtml(run);
  WriteSkipped(o.out, run.skipped);
  WriteFileAtomically(o.out + "/track.html", HtmlPage("Track", body));
  if (!o.overlay.empty()) WriteOverlays(o, run, frames);
}

}  // namespace cosplat

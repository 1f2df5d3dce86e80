// cosplat check: whether a data set tells one story, before anything is trained on it.
#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/charts/svg_drawing.h"
#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/head_model.h"
#include "apps/cosplat/run/html_page.h"
#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/overlay.h"
#include "apps/cosplat/run/run_data.h"
#include "flame/model.h"
#include "flame/track.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/io/scene_check.h"
#include "splat/media/image_glance.h"

namespace cosplat {
namespace {

constexpr size_t kPictures = 12;
constexpr int kPictureSide = 960;  // px

struct CheckOptions {
  std::string data, flame, page, images = "images";
  int resolution = 0;  // 0: the largest that there is
};

std::string PicturesOf(const SceneData& scene) {
  std::vector<const SceneView*> views;
  for (const std::vector<SceneView>* list : {&scene.train, &scene.test})
    for (const SceneView& view : *list) views.push_back(&view);
  const bool has_points = scene.point_colors.size() == scene.points.size() && !scene.points.empty();
  std::string html = has_points ? "<h2>The points over the photographs</h2><p>Each photograph, and "
                                  "what its camera sees of the points: the colours and shapes of "
                                  "both are the same where the data is right.</p>"
                                : "<h2>The images</h2>";
  html += has_points ? "<div class='pairs'>" : "<div class='many'>";
  for (const SceneView* view : Spread(views, kPictures)) {
    Image8 image;
    if (!Problem([&] { image = ReducedTo(LoadViewImage(*view), kPictureSide); }).empty()) continue;
    const Camera camera = view->camera.Resized(image.width, image.height);
    html += FigureHtml(OverBlack(image), view->name);
    if (has_points) html += FigureHtml(PointsOver(scene, camera, OverBlack(image)), "points");
  }
  return html + "</div>";
}

std::string PicturesOf(const FlameModel& flame, const TrackedVideo& video) {
  std::string html =
      "<h2>The mesh over the frames</h2><p>Eyes, mouth and outline of both are in one place where "
      "the data is right.</p><div class='many'>";
  for (const TrackedFrame* frame : Spread(InstantsOf(video), kPictures)) {
    if (!frame->has_image) continue;
    Image8 image;
    const auto load = [&] { image = ReducedTo(LoadTrackedImage(video, *frame), kPictureSide); };
    if (!Problem(load).empty()) continue;
    html += FigureHtml(MeshOver(TrackedVertices(flame, video, *frame),
                                flame.faces,
                                frame->camera.Resized(image.width, image.height),
                                OverBlack(image)),
                       frame->name);
  }
  return html + "</div>";
}

std::string ListOf(const std::vector<Finding>& findings) {
  if (findings.empty()) return "<p>The data tells one story.</p>";
  std::string html = "<ul>";
  for (const Finding& finding : findings)
    html += "<li>" + std::string(finding.wrong ? "<b>Wrong:</b> " : "") + EscapeXml(finding.text) +
            "</li>";
  return html + "</ul>";
}

std::vector<Finding> Check(const CheckOptions& o) {
  DataSplit split;
  split.eval = true;
  split.resolution = o.resolution > 0 ? o.resolution : LargestResolution(o.data);
  ChooseImages(o.images, split);
  std::vector<Finding> findings;
  std::string pictures;
  if (TrackLayoutOf(o.data).empty()) {
    const SceneData scene = LoadSplitScene(o.data, split);
    findings = CheckScene(scene);
    NoteSkipped(scene.train.size() + scene.test.size(), scene.skipped, "images", findings);
    if (!o.page.empty()) pictures = PicturesOf(scene);
  } else {
    split.eval = false;  // frames in one list
    const FlameModel flame = LoadFlameModel(HeadModelOfTrack(o.flame, o.data));
    const TrackedVideo video = LoadSplitVideo(o.data, split, flame);
    findings = CheckTrack(flame, video);
    NoteSkipped(video.train.size() + video.test.size(), video.skipped, "frames", findings);
    if (!o.page.empty()) pictures = PicturesOf(flame, video);
  }
  if (!o.page.empty())
    WriteFileAtomically(
        o.page,
        HtmlPage("Check",
                 "<h1>Check of " + EscapeXml(o.data) + "</h1>" + ListOf(findings) + pictures));
  return findings;
}

}  // namespace

void AddCheck(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "check",
      "whether a data set tells one story: exit code 3 if it trains, but something is wrong");
  const auto o = std::make_shared<CheckOptions>();
  command->add_option("data", o->data, "the data set's folder")->required();
  command->add_option("-o,--out", o->page, "write a page with pictures of it (.html)");
  command->add_option(
      "--flame", o->flame, "FLAME model file, of tracked videos; none: head.npz beside them");
  command->add_option("-i,--images", o->images, "scenes: folder of the images, as of train-scene");
  command
      ->add_option("-r,--resolution",
                   o->resolution,
                   "divide the images' size by this; 0: the largest images that there are")
      ->check(CLI::Range(0, 64));
  command->callback([o] {
    const std::vector<Finding> findings = Check(*o);
    std::printf("%s", ToString(findings).c_str());
    if (AnyWrong(findings)) throw CLI::RuntimeError(kSomethingWrong);
  });
}

}  // namespace cosplat

// Images whose EXIF orientation does not change their proportions (half a turn, a mirror, any of a
// square): whether a scene's cameras are those of the pixels as they are stored or as viewers show
// them.
#include <algorithm>
#include <cmath>

#include "splat/io/view_files.h"
#include "splat/media/image_glance.h"

namespace cosplat {
namespace {

constexpr size_t kViews = 8;
constexpr size_t kPoints = 4000;

// Mean difference, 0 to 255, of the points' colours from the image where the view's camera sees
// them.
double ColorDifference(const SceneView& view, const SceneData& scene) {
  const Image8 image = LoadViewImage(view);
  const size_t count = scene.points.size() / 3, step = std::max<size_t>(1, count / kPoints);
  double sum = 0;
  size_t seen = 0;
  for (size_t i = 0; i < count; i += step) {
    const Sighting at = Sight(view.camera, &scene.points[3 * i]);
    if (!at.inside) continue;
    const uint8_t* pixel =
        &image.data[image.channels * (size_t(at.y) * image.width + size_t(at.x))];
    for (int k = 0; k < 3; ++k) sum += std::abs(pixel[k] - scene.point_colors[3 * i + k]);
    ++seen;
  }
  return seen == 0 ? 0 : sum / double(3 * seen);
}

}  // namespace

void SettleHalfTurns(SceneData& scene) {
  std::vector<SceneView*> views;
  for (std::vector<SceneView>* list : {&scene.train, &scene.test})
    for (SceneView& view : *list)
      if (view.tag != 1) views.push_back(&view);
  if (views.empty()) return;
  double stored = 0, turned = 0;
  const size_t step = std::max<size_t>(1, views.size() / kViews);
  if (scene.point_colors.size() == scene.points.size())
    for (size_t i = 0; i < views.size(); i += step) {
      SceneView as_shown = *views[i];
      as_shown.orientation = as_shown.tag;
      double as_stored = 0, as_turned = 0;
      const auto compare = [&] {
        as_stored = ColorDifference(*views[i], scene);
        as_turned = ColorDifference(as_shown, scene);
      };
      if (!Problem(compare).empty()) continue;  // training skips it
      stored += as_stored, turned += as_turned;
    }
  const bool turn = turned <= stored;  // without points: as viewers show them
  if (turn)
    for (SceneView* view : views) view->orientation = view->tag;
  scene.notes.push_back(
      std::to_string(views.size()) +
      " images have an EXIF orientation that turns them in their place: " +
      (turn ? "they are turned as viewers show them" : "they stay as they are stored") +
      (turned == stored ? "" : ", to which the points' colours fit better"));
}

}  // namespace cosplat

#include "splat/io/scene_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "splat/io/scene_fit.h"

namespace cosplat {
namespace {

constexpr double kSameGlance = 0.5;  // of 255; neighbours in a video that hardly moves have more
// Of 255, on images of kSameSide px; what JPEG compresses once more has less.
constexpr double kSamePixels = 4;
constexpr int kSameSide = 80;
constexpr double kFlat = 1.5;    // contrast, of 255
constexpr size_t kFewViews = 6;  // fewer show a scene only from where they are

std::vector<const SceneView*> AllViews(const SceneData& scene) {
  std::vector<const SceneView*> views;
  for (const std::vector<SceneView>* list : {&scene.train, &scene.test})
    for (const SceneView& view : *list) views.push_back(&view);
  if (!scene.own_split)
    std::stable_sort(views.begin(), views.end(), [](const SceneView* a, const SceneView* b) {
      return a->name < b->name;
    });
  return views;
}

void CheckCameras(const std::vector<const SceneView*>& views, std::vector<Finding>& findings) {
  if (views.size() < 2) return;
  std::map<std::pair<std::array<float, 9>, std::array<float, 3>>, const SceneView*> poses;
  std::array<float, 3> low{}, high{};
  size_t twins = 0;
  std::string pair;
  for (const SceneView* view : views) {
    const std::array<float, 3> center = view->camera.Center();
    if (poses.empty()) low = high = center;
    for (int k = 0; k < 3; ++k)
      low[k] = std::min(low[k], center[k]), high[k] = std::max(high[k], center[k]);
    const auto [at, added] =
        poses.insert({{view->camera.rotation, view->camera.translation}, view});
    if (added) continue;
    if (twins++ == 0) pair = at->second->name + " and " + view->name;
  }
  double spread = 0, far = 0;
  for (int k = 0; k < 3; ++k) {
    spread = std::max<double>(spread, high[k] - low[k]);
    far = std::max<double>({far, std::abs(high[k]), std::abs(low[k])});
  }
  if (spread <= 1e-6 * std::max(far, 1e-3)) {
    findings.push_back({true,
                        "all " + std::to_string(views.size()) +
                            " cameras are in one spot: without parallax there is no depth to "
                            "learn; walk around the scene, or look at the poses"});
  } else if (twins > 0) {
    findings.push_back({2 * twins >= views.size(),
                        std::to_string(twins) + " of " + std::to_string(views.size()) +
                            " cameras have the pose of another one (" + pair + ")"});
  }
}

// Thin or dark things are alike at a glance wherever they are: their pixels, beside the transparent
// ones that both have in common, are not.
bool AreSame(const LookedAt& a, const LookedAt& b) {
  if (DifferenceOf(a.glance, b.glance) > kSameGlance) return false;
  const Image8 left = ReducedTo(OverBlack(a.image), kSameSide),
               right = ReducedTo(OverBlack(b.image), kSameSide);
  if (left.data.size() != right.data.size()) return true;
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < left.data.size(); ++i) {
    if (left.data[i] == 0 && right.data[i] == 0) continue;
    sum += std::abs(left.data[i] - right.data[i]), ++count;
  }
  return sum <= kSamePixels * double(count);
}

void CheckCount(const SceneData& scene, std::vector<Finding>& findings) {
  const size_t views = scene.train.size();
  if (views < kFewViews)
    findings.push_back({false,
                        std::to_string(views) + " training view" + (views == 1 ? "" : "s") +
                            ": what is seen from anywhere else is made up; take 50 to 150 "
                            "photographs from all around"});
}

void CheckContent(const std::vector<LookedAt>& looked, std::vector<Finding>& findings) {
  size_t flat = 0, empty = 0;
  std::string flat_name, empty_name;
  for (const LookedAt& one : looked) {
    if (GreatestAlpha(one.image) == 0) {
      if (empty++ == 0) empty_name = one.view->name;
    } else if (ContrastOf(one.image) < kFlat) {
      if (flat++ == 0) flat_name = one.view->name;
    }
  }
  const auto say = [&](size_t count, const std::string& name, const std::string& what) {
    if (count > 0)
      findings.push_back({2 * count >= looked.size(),
                          std::to_string(count) + " of " + std::to_string(looked.size()) +
                              " images looked at " + what + " (" + name + ")"});
  };
  say(empty, empty_name, "are transparent everywhere: look at their alpha channel");
  say(flat, flat_name, "are nearly of one colour: there is nothing to learn from them");
}

// Test views against all training views.
void CheckTestImages(const SceneData& scene,
                     const std::vector<LookedAt>& looked,
                     std::vector<Finding>& findings) {
  size_t same = 0;
  std::string pair;
  const auto is_test = [&](const LookedAt& one) {
    return !scene.test.empty() && one.view >= &scene.test.front() && one.view <= &scene.test.back();
  };
  std::map<std::string, const SceneView*> files;
  for (const SceneView& view : scene.train) files[view.image_path] = &view;
  for (const SceneView& view : scene.test)
    if (const auto at = files.find(view.image_path); at != files.end() && same++ == 0)
      pair = view.name + " and " + at->second->name;
  for (const LookedAt& test : looked) {
    if (!is_test(test) || files.count(test.view->image_path)) continue;
    if (ContrastOf(test.image) < kFlat) continue;  // said already
    for (const LookedAt& train : looked) {
      if (is_test(train) || !AreSame(test, train)) continue;
      if (same++ == 0) pair = test.view->name + " and " + train.view->name;
      break;
    }
  }
  if (same > 0)
    findings.push_back({true,
                        std::to_string(same) + " test images are training images, too (" + pair +
                            "): their figures say nothing of unseen views; take them out of one "
                            "set"});
}

void CheckRepeated(const std::vector<LookedAt>& looked, std::vector<Finding>& findings) {
  size_t same = 0;
  std::string pair;
  for (size_t i = 0; i + 1 < looked.size(); ++i) {
    const LookedAt &a = looked[i], &b = looked[i + 1];
    if (a.view->camera.translation == b.view->camera.translation) continue;
    if (ContrastOf(a.image) < kFlat || !AreSame(a, b)) continue;
    if (same++ == 0) pair = a.view->name + " and " + b.view->name;
  }
  if (2 * same >= looked.size() && same > 0)
    findings.push_back({true,
                        std::to_string(same) + " of " + std::to_string(looked.size()) +
                            " images looked at are those of the view before, whose camera is "
                            "elsewhere (" +
                            pair + "): look at the image files"});
}

}  // namespace

std::vector<Finding> CheckScene(const SceneData& scene) {
  std::vector<Finding> findings;
  const std::vector<const SceneView*> views = AllViews(scene);
  CheckCount(scene, findings);
  CheckCameras(views, findings);
  std::vector<SkippedFrame> skipped;
  const std::vector<LookedAt> looked = LookAt(views, skipped);
  if (looked.empty() || looked.size() + skipped.size() == views.size())
    CheckSkipped(scene.source, looked.size(), skipped);
  NoteSkipped(looked.size(), skipped, "images looked at", findings);
  CheckContent(looked, findings);
  CheckTestImages(scene, looked, findings);
  CheckRepeated(looked, findings);
  CheckFit(scene, looked, findings);
  return findings;
}

}  // namespace cosplat

#include "splat/io/scene_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>

#include "splat/base/median.h"
#include "splat/base/text.h"
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

using Pose = std::pair<std::array<float, 9>, std::array<float, 3>>;
Pose PoseOf(const SceneView& view) { return {view.camera.rotation, view.camera.translation}; }

// Intrinsics that no photograph has. Returns whether most have them.
bool CheckLenses(const std::vector<const SceneView*>& views, std::vector<Finding>& findings) {
  size_t wrong = 0;
  std::string first;
  for (const SceneView* view : views) {
    const Camera& lens = view->camera;
    std::string problem = LensProblem(lens);
    if (problem.empty() && !(lens.cx >= 0 && lens.cy >= 0 && lens.cx <= float(lens.width) &&
                             lens.cy <= float(lens.height)))
      problem =
          Format("the principal point ({:g}, {:g}) px is outside of the image", lens.cx, lens.cy);
    if (!problem.empty() && wrong++ == 0) first = view->name + ": " + problem;
  }
  if (wrong > 0)
    findings.push_back({true,
                        std::to_string(wrong) + " of " + std::to_string(views.size()) +
                            " cameras have intrinsics that no photograph has (" + first + ")"});
  return 2 * wrong >= views.size();
}

// Images of one size whose field of view differs from most others' by more than calibration does.
void CheckMixedLenses(const std::vector<const SceneView*>& views, std::vector<Finding>& findings) {
  constexpr float kOther = 1.25f;
  std::map<std::pair<int, int>, std::vector<float>> focals;
  for (const SceneView* view : views)
    focals[{view->camera.width, view->camera.height}].push_back(view->camera.fx);
  std::map<std::pair<int, int>, float> medians;
  for (auto& [size, values] : focals) medians[size] = Median(values);
  size_t other = 0;
  std::string first;
  for (const SceneView* view : views) {
    const Camera& lens = view->camera;
    const float usual = medians[{lens.width, lens.height}];
    if (std::max(lens.fx, usual) < kOther * std::min(lens.fx, usual) || other++ > 0) continue;
    first = Format("{}: {:g} px, others {:g} px", view->name, lens.fx, usual);
  }
  if (other > 0)
    findings.push_back({false,
                        std::to_string(other) + " of " + std::to_string(views.size()) +
                            " cameras have another focal length than others of their size (" +
                            first + "): right only if there were several lenses, or a zoom"});
}

// One file under several names, whose cameras differ.
void CheckFiles(const std::vector<const SceneView*>& views, std::vector<Finding>& findings) {
  std::map<std::string, const SceneView*> files;
  size_t same = 0;
  std::string file;
  for (const SceneView* view : views) {
    const auto [at, added] = files.insert({view->image_path, view});
    if (added || at->second->camera.Center() == view->camera.Center()) continue;
    if (same++ == 0) file = view->image_path;
  }
  if (same > 0)
    findings.push_back({true,
                        std::to_string(same) + " of " + std::to_string(views.size()) +
                            " views have the image of another one, whose camera is elsewhere (" +
                            file + "): look at the names in the file of cameras"});
}

// Cameras so far from the others that the scene's size, which rates of learning and limits of
// Gaussians follow, is that of their distance.
void CheckFarCameras(const std::vector<const SceneView*>& views, std::vector<Finding>& findings) {
  constexpr double kFar = 20, kAstray = 100;  // times the distance of three quarters of them
  std::array<double, 3> middle{};
  for (size_t k = 0; k < 3; ++k) {
    std::vector<float> values;
    for (const SceneView* view : views) values.push_back(view->camera.Center()[k]);
    middle[k] = Median(values);
  }
  std::vector<double> distances;
  for (const SceneView* view : views) {
    const std::array<float, 3> c = view->camera.Center();
    distances.push_back(std::hypot(c[0] - middle[0], c[1] - middle[1], c[2] - middle[2]));
  }
  std::vector<double> sorted = distances;
  std::sort(sorted.begin(), sorted.end());
  const double usual = sorted[3 * (sorted.size() - 1) / 4], limit = kFar * usual;
  const auto far = size_t(sorted.end() - std::upper_bound(sorted.begin(), sorted.end(), limit));
  if (usual == 0 || far == 0) return;
  const auto farthest = std::max_element(distances.begin(), distances.end()) - distances.begin();
  const double times = sorted.back() / usual;
  // A path that begins on a tripod is long, too.
  findings.push_back({times > kAstray && (far == 1 || 20 * far <= views.size()),
                      std::to_string(far) + " of " + std::to_string(views.size()) +
                          " cameras are far from the others, " + views[size_t(farthest)]->name +
                          " " + Format("{:.3g}", times) +
                          " times as far from their middle as three quarters of them: the scene's "
                          "size is taken from it; take it out if its pose is wrong"});
}

void CheckCameras(const std::vector<const SceneView*>& views, std::vector<Finding>& findings) {
  if (views.size() < 2) return;
  std::map<Pose, const SceneView*> poses;
  std::array<float, 3> low{}, high{};
  size_t twins = 0;
  std::string pair;
  for (const SceneView* view : views) {
    const std::array<float, 3> center = view->camera.Center();
    if (poses.empty()) low = high = center;
    for (int k = 0; k < 3; ++k)
      low[k] = std::min(low[k], center[k]), high[k] = std::max(high[k], center[k]);
    const auto [at, added] = poses.insert({PoseOf(*view), view});
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
  if (spread > 1e-6 * std::max(far, 1e-3)) CheckFarCameras(views, findings);
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

bool ShowTheSame(const SceneView& a, const SceneView& b) {
  LookedAt images[2];
  const auto load = [](const SceneView& view, LookedAt& one) {
    one.image = LoadViewImage(view);
    one.glance = GlanceOf(one.image);
  };
  // What cannot be read is said elsewhere.
  return Problem([&] { load(a, images[0]), load(b, images[1]); }).empty() &&
         AreSame(images[0], images[1]);
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

bool IsTest(const SceneData& scene, const LookedAt& one) {
  return !scene.test.empty() && one.view >= &scene.test.front() && one.view <= &scene.test.back();
}

// Test views against all training views: by file; by pose, and those looked at, by image.
void CheckTestImages(const SceneData& scene,
                     const std::vector<LookedAt>& looked,
                     std::vector<Finding>& findings) {
  size_t same = 0;
  std::string pair;
  std::map<std::string, const SceneView*> files;
  std::map<Pose, const SceneView*> poses;
  for (const SceneView& view : scene.train) files[view.image_path] = poses[PoseOf(view)] = &view;
  std::set<const SceneView*> known;
  for (const SceneView& view : scene.test) {
    const auto file = files.find(view.image_path);
    const auto pose = poses.find(PoseOf(view));
    if (file == files.end() && pose == poses.end()) continue;
    const SceneView* train = file != files.end() ? file->second : pose->second;
    if (file == files.end() && !ShowTheSame(view, *train)) continue;  // light may change
    known.insert(&view);
    if (same++ == 0) pair = view.name + " and " + train->name;
  }
  for (const LookedAt& test : looked) {
    if (!IsTest(scene, test) || known.count(test.view)) continue;
    if (ContrastOf(test.image) < kFlat) continue;  // said already
    for (const LookedAt& train : looked) {
      if (IsTest(scene, train) || !AreSame(test, train)) continue;
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

// The colour of an image's corners if it is one, else nothing: of renderings and of what was cut
// out.
std::optional<int> BackgroundOf(const Image8& image) {
  constexpr int kAlike = 3;  // of 255
  int low = 255, high = 0;
  for (const int x : {0, image.width - 1})
    for (const int y : {0, image.height - 1})
      for (int c = 0; c < 3; ++c) {
        low = std::min<int>(low, image.at(x, y, c));
        high = std::max<int>(high, image.at(x, y, c));
      }
  if (high - low > kAlike) return {};
  return (low + high) / 2;
}

// Training images on one background, test images on another one.
void CheckBackgrounds(const SceneData& scene,
                      const std::vector<LookedAt>& looked,
                      std::vector<Finding>& findings) {
  constexpr double kDiffer = 32;  // of 255
  constexpr int kOpaque = 128;
  struct Set {
    double images = 0, transparent = 0, plain = 0, sum = 0;
    bool Most(double count) const { return images > 0 && 4 * count >= 3 * images; }
  } sets[2];
  for (const LookedAt& one : looked) {
    Set& set = sets[IsTest(scene, one)];
    ++set.images;
    if (SmallestAlpha(one.image) < kOpaque) {
      ++set.transparent;
    } else if (one.image.channels >= 3) {
      const std::optional<int> color = BackgroundOf(one.image);
      if (color) ++set.plain, set.sum += *color;
    }
  }
  const Set &train = sets[0], &test = sets[1];
  const auto say = [&](const std::string& text) {
    findings.push_back({true, text + ": the test figures compare different backgrounds"});
  };
  if (train.Most(train.transparent) && test.Most(test.images - test.transparent))
    say("training images are transparent around the subject, and test images are not");
  else if (test.Most(test.transparent) && train.Most(train.images - train.transparent))
    say("test images are transparent around the subject, and training images are not");
  else if (train.Most(train.plain) && test.Most(test.plain) &&
           std::abs(train.sum / train.plain - test.sum / test.plain) > kDiffer)
    say(Format("the background of training images is a grey of {:.0f}, and of test images {:.0f}",
               train.sum / train.plain,
               test.sum / test.plain));
}

void CheckMasks(const std::vector<LookedAt>& looked, std::vector<Finding>& findings) {
  size_t all = 0, masked = 0;
  std::string name;
  for (const LookedAt& one : looked) {
    masked += one.ignored >= 0;
    if (one.ignored < 1) continue;
    if (all++ == 0) name = one.view->name;
  }
  if (all > 0)
    findings.push_back({2 * all >= masked,
                        std::to_string(all) + " of " + std::to_string(masked) +
                            " masks looked at are black everywhere, which leaves nothing of the "
                            "image (" +
                            name + ")"});
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
  CheckFiles(views, findings);
  CheckCameras(views, findings);
  const bool lenses_wrong = CheckLenses(views, findings);
  CheckMixedLenses(views, findings);
  std::vector<SkippedFrame> skipped;
  const std::vector<LookedAt> looked = LookAt(views, skipped);
  if (looked.empty() || looked.size() + skipped.size() == views.size())
    CheckSkipped(scene.source, looked.size(), skipped);
  NoteSkipped(looked.size(), skipped, "images looked at", findings);
  CheckContent(looked, findings);
  CheckMasks(looked, findings);
  CheckBackgrounds(scene, looked, findings);
  CheckTestImages(scene, looked, findings);
  CheckRepeated(looked, findings);
  if (!lenses_wrong) CheckFit(scene, looked, findings);
  return findings;
}

}  // namespace cosplat

#include "apps/cosplat/run/memory_plan.h"

#include <algorithm>
#include <cstdio>

#include "splat/base/error.h"
#include "splat/base/text.h"
#include "splat/gaussians.h"
#include "splat/train/subject/scene_subject.h"

namespace cosplat {
namespace {

// Measured: besides parameters, gradients and two moments a Gaussian takes up to 341 bytes
// (docs/performance.md, *Memory*), and a pixel in work takes 28 bytes of rendering, 12 of exposure
// and 15 of evaluation.
constexpr size_t kBesideParameters = 350;
// 14 of these bytes are statistics and counters, by their sizes; the rest is room.
constexpr size_t kBesideCopies = 50;
constexpr size_t kPerPixel = 56;
// Two layers, the target and the mask of two frames; floats while layers are put together, and of
// what is shown.
constexpr size_t kPerLayerPixel = 64;
// Bytes of a Gaussian that is only rendered: all are at once in the images of evaluation, and
// between rounds all Gaussians of blocks that a view shows.
constexpr size_t kDrawn = 180;
constexpr size_t kProgram = size_t(160) << 20;
constexpr double kPhotographShare = 0.25;
constexpr double kGb = 1e9;

// Parameters are there four times in a step: with gradients (of one view or summed) and two
// moments. They are there six times, without gradients and what drawing takes, while a copy is made
// in the middle of a run, which has moments of its own (StepEngine::CaughtUp), and while a
// checkpoint is read, beside the bytes of its file. Several ranks take less.
size_t BytesPerGaussian(const SceneTrainOptions& o) {
  Gaussians one;
  one.degree = o.sh_degree;
  size_t numbers = 0;
  for (int a = 0; a < kAttributeCount; ++a) numbers += size_t(one.width(a));
  const size_t parameters = sizeof(float) * numbers;
  const size_t trained =
      std::max(4 * parameters + kBesideParameters, 6 * parameters + kBesideCopies);
  if (o.blocks == 1) return trained;
  return std::max(trained / o.blocks, parameters + kDrawn);
}

std::string Gb(double bytes) { return Format("{:.2f} GB", bytes / kGb); }

}  // namespace

MemoryPlan PlanMemory(const SceneTrainOptions& o, const SceneData& scene) {
  MemoryPlan plan;
  plan.program = kProgram;
  size_t pixels = 0;
  for (const auto* views : {&scene.train, &scene.test})
    for (const SceneView& view : *views) {
      pixels = std::max(pixels, ImageBytes(view.camera) / 4);
      plan.all_images += ImageBytes(view.camera);
    }
  plan.all_images += plan.all_images / 4;
  plan.blocks = o.blocks;
  plan.in_work = pixels * (o.blocks == 1 ? kPerPixel : kPerPixel + kPerLayerPixel);
  plan.per_gaussian = BytesPerGaussian(o);
  plan.gaussians = o.max_gaussians;
  plan.images = o.blocks == 1 ? plan.all_images : 0;
  if (o.blocks == 1 && o.memory_gb == 0) return plan;
  // Two photographs that are not kept are held at any time, at the file's size while they are read.
  size_t largest = 0;
  for (const SceneView& view : scene.train)
    largest = std::max(largest, ImageBytes(view.file_camera));
  plan.in_work += 2 * largest;
  if (o.memory_gb == 0) return plan;
  const double rest = double(o.memory_gb) * kGb - double(plan.program + plan.in_work);
  const double at_first = double(scene.points.size() / 3 * plan.per_gaussian);
  if (rest < at_first || rest <= 0)
    throw Error("--memory",
                Gb(o.memory_gb * kGb) +
                    " is too little: the program, an image and the first Gaussians take " +
                    Gb(double(plan.program + plan.in_work) + at_first));
  const double wanted = double(plan.gaussians * plan.per_gaussian);
  // Blocks read a photograph once a round.
  const double min = o.blocks == 1 ? kPhotographShare * rest : 0;
  const double images = std::max(min, rest - wanted);
  plan.images = std::min(plan.all_images, size_t(std::min(images, rest - at_first)));
  plan.gaussians =
      std::min(plan.gaussians, size_t((rest - double(plan.images)) / double(plan.per_gaussian)));
  return plan;
}

std::string ToString(const MemoryPlan& plan) {
  std::string text = "memory: at most " + Gb(double(plan.total())) + ": " +
                     Gb(double(plan.gaussians * plan.per_gaussian)) + " for " +
                     WithThousands(plan.gaussians) + " Gaussians" +
                     (plan.blocks > 1 ? " in " + std::to_string(plan.blocks) + " blocks" : "") +
                     ", " + Gb(double(plan.images)) + " for photographs";
  if (plan.images < plan.all_images)
    text += " (of " + Gb(double(plan.all_images)) + "; the others are read again)";
  return text;
}

}  // namespace cosplat

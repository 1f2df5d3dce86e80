// What a scene's training will hold in memory, known before it begins, and how it keeps to a limit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>

#include "apps/cosplat/options/scene_options.h"
#include "splat/io/dataset.h"

namespace cosplat {

// In bytes.
struct MemoryPlan {
  size_t program = 0;       // code, libraries, threads' scratch
  size_t in_work = 0;       // of the pixels of the image that is trained on
  size_t images = 0;        // photographs kept in memory, and reduced copies of them
  size_t all_images = 0;    // if all are
  size_t per_gaussian = 0;  // of the scene; in blocks, as a mean or when all are drawn
  size_t gaussians = 0;     // at most: a number
  size_t blocks = 1;

  // Gaussians that are trained at a time.
  size_t at_once() const { return std::max<size_t>(1, gaussians / blocks); }
  size_t total() const { return program + in_work + images + gaussians * per_gaussian; }
  // How much of `images` is for the photographs themselves (LoadTrainFrames), and for their reduced
  // copies (ReducedFrames).
  size_t for_photographs() const { return images < all_images ? images / 5 * 4 : size_t(-1); }
  size_t for_reduced() const { return images < all_images ? images / 5 : size_t(-1); }
};

// Without a limit (options.memory_gb 0), for options.max_gaussians and all images, or, of a scene
// that is trained in blocks, no image. With one, photographs beyond what is left are read again in
// every step, at worst all but a quarter of it; of blocks, at worst all, once a round. Then there
// are fewer Gaussians, as many with any number of threads on any machine. Throws Error
// if not even those that training begins with fit.
MemoryPlan PlanMemory(const SceneTrainOptions& options, const SceneData& scene);

// "memory: at most 3.49 GB: 3.06 GB for 2,000,000 Gaussians, 0.25 GB for photographs".
std::string ToString(const MemoryPlan& plan);

}  // namespace cosplat

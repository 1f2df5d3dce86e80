// Checksums of the data that a run reads, by which a checkpoint is known to be of this data.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "flame/track.h"
#include "splat/base/image.h"
#include "splat/gaussians.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

// In an order that does not change, with names for errors: "training frame r_3".
using DataChecksums = std::vector<std::pair<std::string, uint32_t>>;

// Of views or tracked frames.
template <class T>
std::vector<std::string> NamesOf(const std::vector<T>& all) {
  std::vector<std::string> names;
  for (const T& one : all) names.push_back(one.name);
  return names;
}

// Camera and image of each frame; frames: [names].
void AddFrames(const std::string& kind,
               const std::vector<std::string>& names,
               const TrainFrame* frames,
               DataChecksums& checksums);
// Parameters of each frame, and its camera.
void AddTrack(const std::string& kind,
              const std::vector<TrackedFrame>& frames,
              DataChecksums& checksums);
void AddImages(const std::string& kind,
               const std::vector<Image8>& images,
               DataChecksums& checksums);
void AddGaussians(const std::string& name, const Gaussians& gaussians, DataChecksums& checksums);
void AddText(const std::string& name, const std::string& text, DataChecksums& checksums);
// A file, or all files of a folder; nothing if `path` is empty. Throws Error as ReadFile does.
void AddFiles(const std::string& name, const std::string& path, DataChecksums& checksums);

}  // namespace cosplat

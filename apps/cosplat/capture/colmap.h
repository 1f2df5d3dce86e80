// Cameras of photographs by COLMAP (Schönberger and Frahm 2016), a program of its own
// (colmap_program.h), of any version from 3.8 to 4.2.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/cosplat/capture/colmap_program.h"
#include "apps/cosplat/capture/photographs.h"

namespace cosplat {

struct ColmapSettings {
  std::string matching;  // "exhaustive": every pair; "sequential": neighbours by name; "auto"
  int max_size = 1600;   // px: the longer side of the images made for training
  int threads = 1;
  bool quiet = false;
  // Options ("--FeatureExtraction.type") and their values for features and matches, in place of
  // ours: each goes to those of the two commands that take it.
  std::vector<std::pair<std::string, std::string>> features;
};

// "exhaustive" or "sequential": what "auto" means for these photographs.
std::string ResolveMatching(const std::string& matching, const Photographs& photographs);

struct Registration {
  std::vector<std::string> registered, not_registered;  // names of photographs, sorted
  size_t points = 0;
  double mean_error = 0;  // px of the photographs: of the points' reprojection
};

// Finds the cameras of workspace/photographs (as GatherPhotographs fills it) and writes the
// data set `folder`: images/ without distortion and sparse/0 with their pinhole cameras, the
// largest of the models that COLMAP found. What COLMAP printed is in workspace/log.txt; features
// and matches that an interrupted call left in workspace/database.db are used. `folder` appears, or
// is replaced, once it is whole. Throws Error if a command fails, after its last lines on standard
// error, if none takes one of settings.features, or if fewer than kMinPhotographs have a camera.
Registration FindCameras(const Photographs& photographs,
                         ColmapProgram& program,
                         const ColmapSettings& settings,
                         const std::string& workspace,
                         const std::string& folder);

}  // namespace cosplat

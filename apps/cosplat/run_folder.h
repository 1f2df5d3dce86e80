// The output folder of a run, laid out as other tools read it (3DGS):
//   cfg_args  config.ini  run.json  cameras.json  input.ply
//   point_cloud/iteration_N/point_cloud.ply
//   test/ours_N/{renders,gt,masks}/00000.png  results.json  per_view.json  stats.json
#pragma once

#include <string>
#include <vector>

#include "apps/cosplat/train_options.h"
#include "splat/base/json.h"
#include "splat/dataset.h"

namespace cosplat {

// cfg_args (3DGS's one line), config.ini (everything, for --config) and run.json (for render,
// report).
void WriteRunConfiguration(const std::string& folder,
                           const TrainOptions& options,
                           const std::string& config_ini,
                           const Json& run);

// Throws Error when `folder` holds no run.
Json ReadRun(const std::string& folder);

Json CameraToJson(const Camera& camera);
Camera CameraFromJson(const JsonField& json);

// Writes point_cloud/iteration_N/point_cloud.ply in 3DGS's SH.
void SaveSplats(const std::string& folder, int iteration, Gaussians gaussians);

// The highest N of point_cloud/iteration_N; Error when there is none.
int LatestIteration(const std::string& folder);
std::string SplatPath(const std::string& folder, int iteration);

void WriteStatistics(const std::string& folder,
                     const TrainingStatistics& statistics,
                     size_t skipped_frames);

// Peak resident memory of this process, MB.
double PeakMegabytes();

}  // namespace cosplat

// The output folder of a run, laid out as other tools read it (3DGS):
//   cfg_args  config.ini  run.json  cameras.json  input.ply
//   point_cloud/iteration_N/point_cloud.ply
//   test/ours_N/{renders,gt,masks}/00000.png  results.json  per_view.json  stats.json
#pragma once

#include <string>
#include <vector>

#include "apps/cosplat/options/train_options.h"
#include "splat/base/json.h"
#include "splat/io/dataset.h"

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

// Whether files can hold the run's colours (IsHarmonic in splat/basis.h); where not, says in a
// line, unless quiet, that nothing will be saved.
bool CanSaveSplats(const TrainOptions& options);
// Throws Error where nothing was saved because of that.
void RequireSplats(const JsonField& run);

// Writes point_cloud/iteration_N/point_cloud.ply in 3DGS's SH.
void SaveSplats(const std::string& folder, int iteration, Gaussians gaussians);

// The run's last saved iteration: run.json's, or the highest there is of an unfinished run. Error
// when nothing was saved; but run.json's where that cannot be: its test images are there.
int SavedIteration(const std::string& folder, const JsonField& run);
std::string SplatPath(const std::string& folder, int iteration);

// skipped_frames.json: names and reasons; nothing when none was skipped.
void WriteSkipped(const std::string& folder, const std::vector<SkippedFrame>& skipped);

void WriteStatistics(const std::string& folder,
                     const TrainingStatistics& statistics,
                     size_t skipped_frames);

// Peak resident memory of this process, MB.
double PeakMegabytes();

}  // namespace cosplat

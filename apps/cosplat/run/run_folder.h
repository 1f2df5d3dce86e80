// The output folder of a run, in 3DGS's layout, which other tools read:
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

// Writes cfg_args (one line, as in 3DGS), config.ini (all options, for --config) and run.json (for
// render and report).
void WriteRunConfiguration(const std::string& folder,
                           const TrainOptions& options,
                           const std::string& config_ini,
                           const Json& run);

// Throws Error(option, ...) if `folder`, which it names for results, is that of the data, or a
// folder of images in there, or a file there that is older than the run.
void RefuseDataFolder(const std::string& option,
                      const std::string& folder,
                      const std::string& source,
                      const std::string& run = "");

// Whether a path is that folder or something in it.
bool IsInside(const std::string& path, const std::string& folder);
// Throws Error(option, ...) if the file or folder that it names for output is the input.
void RefuseInput(const std::string& option, const std::string& output, const std::string& input);

// Removes what an earlier run, finished or not, left in its folder: its checkpoint, results and
// splats. Other files stay. Throws Error if that is not possible.
void RemoveRun(const std::string& folder);

// Whether it is a run's folder, ours or one that 3DGS's code wrote.
bool IsRun(const std::string& folder);
// run.json, or what it would say of a folder of 3DGS's own. Throws Error if `folder` holds no run.
JsonField ReadRun(const std::string& folder);
// The latter, of a folder that 3DGS's own code wrote: cfg_args in place of run.json.
//
// What run.json would say: source, split, degree, background, and the highest iteration saved.
// Throws Error naming the field if cfg_args is not 3DGS's line ("Namespace(eval=True, ...)").
Json RunOfCfgArgs(const std::string& folder);

// Whether checks found nothing wrong with the run's data (AnyWrong); of older runs, true.
bool HadSoundData(const std::string& folder);

Json CameraToJson(const Camera& camera);
Camera CameraFromJson(const JsonField& json);

// Whether splat files can represent the run's colour basis (IsHarmonic in splat/basis.h). If not,
// prints a line, unless quiet, that nothing will be saved.
bool CanSaveSplats(const TrainOptions& options);
// Throws Error if the run saved no splats for that reason.
void RequireSplats(const JsonField& run);

// Writes point_cloud/iteration_N/point_cloud.ply with the colours converted to 3DGS's SH.
void SaveSplats(const std::string& folder, int iteration, Gaussians gaussians);
// The path of that file, in a folder that is made if it is not there.
std::string MakeSplatPath(const std::string& folder, int iteration);

// N of a folder's name "iteration_N", and the highest one that a run has on disk; -1: none.
int IterationIn(const std::string& name);
int LastIteration(const std::string& folder);
// The run's last saved iteration: the one in run.json, or the highest one on disk if training was
// interrupted. Throws Error if nothing was saved, except for runs that cannot save splats: these
// still have test images at the iteration in run.json.
int SavedIteration(const std::string& folder, const JsonField& run);
std::string SplatPath(const std::string& folder, int iteration);

// Writes skipped_frames.json with names and reasons, or no file if no frame was skipped.
void WriteSkipped(const std::string& folder, const std::vector<SkippedFrame>& skipped);

// blocks: what is to be said of each, of a scene trained in blocks.
void WriteStatistics(const std::string& folder,
                     const TrainingStatistics& statistics,
                     size_t skipped_frames,
                     const Json& blocks = {});

// Peak resident memory of this process in MB.
double PeakMegabytes();

}  // namespace cosplat

// Sub-commands of `cosplat`. Each Add* function declares its options on `app` and the callback that
// runs when the sub-command is chosen. Errors are thrown as Error and printed by main.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "splat/render/device.h"

namespace cosplat {

class FrameSource;
class Ranks;
struct AvatarOptions;
struct SceneTrainOptions;
struct TrackRunOptions;

void AddAvatar(CLI::App& app);
void AddCheck(CLI::App& app);
void AddExport(CLI::App& app);
void AddInfo(CLI::App& app);
void AddLandmarks(CLI::App& app);
void AddLatency(CLI::App& app);
void AddMakeHead(CLI::App& app);
void AddMetrics(CLI::App& app);
void AddPlay(CLI::App& app);
void AddRender(CLI::App& app);
void AddReport(CLI::App& app);
void AddScene(CLI::App& app);
void AddSend(CLI::App& app);
void AddServe(CLI::App& app);
void AddStream(CLI::App& app);
void AddTrack(CLI::App& app);
void AddTrainAvatar(CLI::App& app);
void AddTrainScene(CLI::App& app);
void AddVoice(CLI::App& app);
void AddWebcam(CLI::App& app);

// What these commands do, for commands that include them.

struct LandmarkRunOptions {
  std::string source;  // a video, or a folder of images
  std::string out;     // .json; mattes go into mattes/ beside it
  int size = 512;      // px, the images' longest side; 0: of whole frames
  int frames = 0;      // at most so many are chosen; 0: all
  bool quiet = false;
  std::string matte;  // own mattes, of OwnMattes; or empty
};

// Writes report.html of the run in `model`. Throws Error if it has no test images.
void WriteReport(const std::string& model, bool quiet);
// As `render --orbit`, as without it, or as `render --drive DRIVE`.
enum class VideoOf { kOrbit, kTestFrames, kSequence };
// `out` is a folder or ends in .mp4. Throws Error if the run saved no splats.
void RenderVideo(const std::string& model,
                 VideoOf what,
                 const std::string& drive,
                 const std::string& out,
                 std::optional<Device> device,
                 bool quiet);
// As `train-avatar`. `config`: of ConfigOf. Returns false if the data was said to be wrong
// (run/notes.h). Throws Error before anything is written if the data or the options cannot be used.
bool TrainAvatar(AvatarOptions options, const std::string& config);
// As `train-scene`: reads o.source, trains, and writes the run folder o.model (run_folder.h).
// Prints what it reads and reaches, unless quiet. Resumes an interrupted run, and leaves a finished
// one as it is, where the options say so. Returns false if the data was said to be wrong
// (run/notes.h). Throws Error before anything is written if the data or the options cannot be used;
// Stopped as RunTraining does. ranks: with whom it trains; rank 0 alone writes and prints.
bool TrainScene(SceneTrainOptions o, const std::string& config, std::shared_ptr<Ranks> ranks);
// As `landmarks`, of frames of options.source, which are cropped to the head where it says so. The
// first use installs MediaPipe's packages by npm into the user's cache folder, and says so; later
// ones need no network. Shows progress and prints a summary. Throws Error that says what to install
// if node, npm or Chromium is missing, and if one of them fails or no frame has a face; nothing is
// written then.
void DetectLandmarks(const LandmarkRunOptions& options, FrameSource& frames);
// The options of `landmarks` that `avatar` has, too.
void DeclareLandmarks(LandmarkRunOptions& options, CLI::App& command);
// The options of `track` that `avatar` has, too.
void DeclareTracking(TrackRunOptions& options, CLI::App& command);

}  // namespace cosplat

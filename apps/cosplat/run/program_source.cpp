#include "apps/cosplat/run/program_source.h"

#include <filesystem>
#include <string_view>
#include <vector>

#include "apps/cosplat/run/process.h"

namespace cosplat {
namespace {

constexpr std::string_view kWebcam = "webcam:", kMicrophone = "audio:", kSoundInput = "audio:-";

std::vector<std::string> CommandOf(const std::string& drive) {
  std::vector<std::string> command{std::filesystem::read_symlink("/proc/self/exe").string()};
  if (drive == kMicrophone || drive == kSoundInput) {
    command.emplace_back("voice");
    if (drive == kSoundInput) command.emplace_back("-");
    return command;
  }
  command.emplace_back("webcam");
  const std::string camera = drive.substr(kWebcam.size());
  if (!camera.empty()) command.insert(command.end(), {"--camera", camera});
  return command;
}

// The lines of the command's output.
class ProgramSource : public LiveSource {
 public:
  ProgramSource(const std::string& drive, const LiveSourceOptions& options)
      : child_(CommandOf(drive),
               {},
               ChildProcess::Errors::kAsOurs,
               drive == kSoundInput ? ChildProcess::Input::kOurs : ChildProcess::Input::kNothing),
        lines_(OpenLineSource(child_.output(), drive, options)) {}

  bool Poll(int64_t now_ns, LiveFrame& out) override { return lines_->Poll(now_ns, out); }
  bool Ended() const override { return lines_->Ended(); }
  LiveCounts Counts() const override { return lines_->Counts(); }
  std::string Description() const override { return lines_->Description(); }

 private:
  ChildProcess child_;
  std::unique_ptr<LiveSource> lines_;
};

}  // namespace

bool IsProgramDrive(const std::string& drive) {
  return drive.starts_with(kWebcam) || drive == kMicrophone || drive == kSoundInput;
}

std::unique_ptr<LiveSource> OpenProgram(const std::string& drive,
                                        const LiveSourceOptions& options) {
  return std::make_unique<ProgramSource>(drive, options);
}

std::unique_ptr<LiveSource> OpenLive(const std::string& drive, const LiveSourceOptions& options) {
  return IsProgramDrive(drive) ? OpenProgram(drive, options) : OpenLiveSource(drive, options);
}

}  // namespace cosplat

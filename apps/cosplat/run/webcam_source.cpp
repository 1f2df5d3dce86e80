#include "apps/cosplat/run/webcam_source.h"

#include <filesystem>
#include <string_view>
#include <vector>

#include "apps/cosplat/run/process.h"

namespace cosplat {
namespace {

constexpr std::string_view kScheme = "webcam:";

// The lines of the command's output.
class WebcamSource : public LiveSource {
 public:
  WebcamSource(const std::string& drive, const LiveSourceOptions& options)
      : child_(CommandOf(drive), {}, ChildProcess::Errors::kAsOurs),
        lines_(OpenLineSource(child_.output(), drive, options)) {}

  bool Poll(int64_t now_ns, LiveFrame& out) override { return lines_->Poll(now_ns, out); }
  bool Ended() const override { return lines_->Ended(); }
  LiveCounts Counts() const override { return lines_->Counts(); }
  std::string Description() const override { return lines_->Description(); }

 private:
  static std::vector<std::string> CommandOf(const std::string& drive) {
    std::vector<std::string> command{std::filesystem::read_symlink("/proc/self/exe").string(),
                                     "webcam"};
    const std::string camera = drive.substr(kScheme.size());
    if (!camera.empty()) command.insert(command.end(), {"--camera", camera});
    return command;
  }

  ChildProcess child_;
  std::unique_ptr<LiveSource> lines_;
};

}  // namespace

bool IsWebcamDrive(const std::string& drive) { return drive.starts_with(kScheme); }

std::unique_ptr<LiveSource> OpenWebcam(const std::string& drive, const LiveSourceOptions& options) {
  return std::make_unique<WebcamSource>(drive, options);
}

}  // namespace cosplat

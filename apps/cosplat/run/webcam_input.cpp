#include "apps/cosplat/run/webcam_input.h"

#include <filesystem>
#include <string_view>
#include <utility>

#include "apps/cosplat/run/process.h"
#include "avatar/live/packet_input.h"

namespace cosplat {
namespace {

constexpr std::string_view kScheme = "webcam:";

// The lines of the command's output.
class WebcamInput : public PacketInput {
 public:
  explicit WebcamInput(const std::string& drive)
      : child_(CommandOf(drive), {}, ChildProcess::Errors::kAsOurs),
        lines_(OpenLineInput(child_.output(), drive)) {}

  void Receive(NewestPackets& packets, LiveCounts& counts) override {
    lines_->Receive(packets, counts);
  }
  bool Ended() const override { return lines_->Ended(); }
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
  std::unique_ptr<PacketInput> lines_;
};

}  // namespace

bool IsWebcamDrive(const std::string& drive) { return drive.starts_with(kScheme); }

std::unique_ptr<LiveSource> OpenWebcam(const std::string& drive, const LiveSourceOptions& options) {
  return OpenJsonSource(
      std::make_unique<WebcamInput>(drive), ChooseBlendshapeMap("", options), options);
}

}  // namespace cosplat

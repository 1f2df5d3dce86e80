// "webcam:" and "audio:": the commands `cosplat webcam` and `cosplat voice`, whose lines are the
// drive.
#include <cstdio>
#include <string_view>
#include <vector>

#include "avatar/live/packet_input.h"
#include "splat/base/error.h"
#include "splat/base/process.h"

namespace cosplat {
namespace {

constexpr std::string_view kWebcam = "webcam:", kMicrophone = "audio:", kSoundInput = "audio:-";

std::vector<std::string> CommandOf(const std::string& drive, const std::string& program) {
  std::vector<std::string> command{FindProgram(program.empty() ? "cosplat" : program)};
  if (command[0].empty())
    throw Error(drive, "needs the program " + (program.empty() ? "cosplat in PATH" : program));
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

// The lines of a command's output. What it has to say goes to standard error, and why it failed to
// the counts as well: a host may have no terminal.
class ProgramInput : public PacketInput {
 public:
  ProgramInput(const std::string& drive, const std::string& program)
      : child_(CommandOf(drive, program),
               {},
               ChildProcess::Errors::kApart,
               drive == kSoundInput ? ChildProcess::Input::kOurs : ChildProcess::Input::kNothing),
        errors_(child_.errors(), [this](const std::string& line) { Heard(line); }),
        lines_(OpenLineInput(child_.output(), drive)) {}

  void Receive(NewestPackets& packets, LiveCounts& counts) override {
    if (Ended()) return;
    lines_->Receive(packets, counts);
    ended_ = lines_->Ended() && child_.HasEnded();
    errors_.ReadAvailable(0);
    if (!ended_) return;
    errors_.Finish();
    const int status = child_.Wait();
    if (status == 0) return;
    counts.last_problem =
        status > 128 || last_words_.empty() ? Description() + ": " + ExitText(status) : last_words_;
  }
  bool Ended() const override { return ended_; }
  std::string Description() const override { return lines_->Description(); }

 private:
  void Heard(const std::string& line) {
    std::fprintf(stderr, "%s\n", line.c_str());
    last_words_ = line;
  }

  ChildProcess child_;
  OutputLines errors_;
  std::unique_ptr<PacketInput> lines_;
  std::string last_words_;
  bool ended_ = false;
};

}  // namespace

bool IsProgramDrive(const std::string& drive) {
  return drive.starts_with(kWebcam) || drive == kMicrophone || drive == kSoundInput;
}

std::unique_ptr<LiveSource> OpenProgramSource(const std::string& drive,
                                              const LiveSourceOptions& options) {
  return OpenJsonSource(std::make_unique<ProgramInput>(drive, options.program),
                        ChooseBlendshapeMap("", options),
                        options);
}

}  // namespace cosplat

// cosplat-trainer: `cosplat avatar` in a page, of images in the module's file system.
#include "apps/cosplat/commands.h"
#include "apps/cosplat/program.h"
#include "apps/cosplat/run/mediapipe.h"
#include "splat/base/process.h"

// What the page does for the commands: it finds faces, as apps/landmarks/detect.mjs does elsewhere,
// and shows avatars itself.
namespace cosplat {

std::vector<std::string> Mediapipe::Command(const std::string& program,
                                            const std::vector<std::string>& options) const {
  std::vector<std::string> command{program};
  command.insert(command.end(), options.begin(), options.end());
  return command;
}

Mediapipe FindMediapipe(bool) { return {}; }

void WriteReport(const std::string&, bool) {}
void RenderVideo(const std::string&,
                 VideoOf,
                 const std::string&,
                 const std::string&,
                 std::optional<Device>,
                 bool) {}

}  // namespace cosplat

// 75 (sysexits' EX_TEMPFAIL): the page has something to do first, and calls again.
int main(int argc, char** argv) {
  constexpr int kPageIsAsked = 75;
  try {
    return cosplat::RunProgram(
        "cosplat-trainer",
        "Head avatars, in a page.",
        [](CLI::App& app) {
          app.require_subcommand(1);
          cosplat::AddAvatar(app);
          cosplat::AddTrainAvatar(app);
        },
        argc,
        argv);
  } catch (const cosplat::PageIsAsked&) {
    return kPageIsAsked;
  }
}

// What the page does for the commands: it finds faces, as apps/landmarks/detect.mjs does elsewhere,
// and shows avatars itself.
#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/mediapipe.h"

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

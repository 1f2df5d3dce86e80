#include "avatar/live/source.h"

#include <unistd.h>

#include "avatar/live/json_source.h"
#include "avatar/live/recording.h"
#include "splat/base/error.h"

namespace cosplat {

std::unique_ptr<LiveSource> OpenLiveSource(const std::string& drive,
                                           const LiveSourceOptions& options) {
  if (drive == "stdin:")
    return OpenJsonSource(OpenLineInput(STDIN_FILENO, "standard input"), options);
  if (drive.find("://") == std::string::npos) return OpenRecording(drive, options);
  const DriveAddress address = ParseDriveAddress(drive);
  if (address.scheme == "udp") return OpenJsonSource(OpenUdpInput(address), options);
  throw Error(drive,
              "",
              "expected a file, a folder, stdin:, udp://HOST:PORT or "
              "vmc://HOST:PORT?matrix=FILE");
}

}  // namespace cosplat

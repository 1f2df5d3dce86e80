#include "avatar/live/source.h"

#include <unistd.h>

#include "avatar/live/packet_input.h"
#include "avatar/live/recording.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

std::unique_ptr<LiveSource> OpenVmc(const DriveAddress& address, const LiveSourceOptions& options) {
  constexpr std::string_view kMatrix = "matrix=";
  if (!address.query.starts_with(kMatrix) || address.query.size() == kMatrix.size())
    throw Error(address.drive, "matrix", "is missing: expected vmc://HOST:PORT?matrix=FILE");
  BlendshapeMatrix matrix = BlendshapeMatrix::Read(address.query.substr(kMatrix.size()));
  return OpenVmcSource(OpenUdpInput(address), std::move(matrix), options);
}

}  // namespace

std::unique_ptr<LiveSource> OpenLiveSource(const std::string& drive,
                                           const LiveSourceOptions& options) {
  if (drive == "stdin:")
    return OpenJsonSource(OpenLineInput(STDIN_FILENO, "standard input"), options);
  if (drive.find("://") == std::string::npos) return OpenRecording(drive, options);
  const DriveAddress address = ParseDriveAddress(drive);
  if (address.scheme == "udp") return OpenJsonSource(OpenUdpInput(address), options);
  if (address.scheme == "vmc") return OpenVmc(address, options);
  throw Error(drive,
              "expected a file, a folder, stdin:, udp://HOST:PORT or "
              "vmc://HOST:PORT?matrix=FILE");
}

}  // namespace cosplat

#include "avatar/live/source.h"

#include <unistd.h>

#include <filesystem>
#include <string_view>

#include "avatar/live/blendshape_matrix.h"
#include "avatar/live/packet_input.h"
#include "avatar/live/recording.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// FILE of the query "matrix=FILE"; "" if there is no query.
std::string MatrixIn(const DriveAddress& address) {
  constexpr std::string_view kMatrix = "matrix=";
  if (address.query.empty()) return "";
  if (!address.query.starts_with(kMatrix) || address.query.size() == kMatrix.size())
    throw Error(address.drive,
                "?" + address.query,
                "expected " + address.scheme + "://HOST:PORT?matrix=FILE");
  return address.query.substr(kMatrix.size());
}

}  // namespace

ChosenMap ChooseBlendshapeMap(const std::string& matrix, const LiveSourceOptions& options) {
  if (!matrix.empty())
    return {ReadBlendshapeMatrix(matrix), std::filesystem::path(matrix).filename().string()};
  if (options.blendshapes) return {*options.blendshapes, "the avatar's own blendshape map"};
  const bool lids = options.flame && options.flame->has_eyelids;
  return {GeneralBlendshapeMap(options.flame),
          Format("the general blendshape map: jaw{} and gaze only", lids ? ", eyelids" : "")};
}

std::string NotesOf(const LiveCounts& counts) {
  const std::string unused = counts.unused.Text();
  if (counts.senders.empty()) return unused;
  return "two senders take turns: " + counts.senders + (unused.empty() ? "" : "; " + unused);
}

std::string ToString(const LiveCounts& counts) {
  if (counts.packets == 0) return "no packet has arrived";
  std::string text = Format("{} packets, {} frames taken", counts.packets, counts.frames);
  const auto add = [&](uint64_t count, const char* what) {
    if (count > 0) text += ", " + std::to_string(count) + " " + what;
  };
  add(counts.unusable, "packets without anything usable");
  add(counts.replaced, "frames replaced by newer ones");
  add(counts.reordered, "out of order");
  add(counts.malformed, "malformed");
  add(counts.oversize, "too long");
  add(counts.flooded, "too many at once");
  const std::string notes = NotesOf(counts);
  return notes.empty() ? text : text + "; " + notes;
}

std::unique_ptr<LiveSource> OpenLiveSource(const std::string& drive,
                                           const LiveSourceOptions& options) {
  if (drive == "stdin:")
    return OpenJsonSource(
        OpenLineInput(STDIN_FILENO, "standard input"), ChooseBlendshapeMap("", options), options);
  if (drive.find("://") == std::string::npos) return OpenRecording(drive, options);
  const DriveAddress address = ParseDriveAddress(drive);
  if (address.scheme != "udp" && address.scheme != "vmc")
    throw Error(drive, "expected a file, a folder, stdin:, udp://HOST:PORT or vmc://HOST:PORT");
  ChosenMap map = ChooseBlendshapeMap(MatrixIn(address), options);
  const auto open = address.scheme == "udp" ? OpenJsonSource : OpenVmcSource;
  return open(OpenUdpInput(address), std::move(map), options);
}

}  // namespace cosplat

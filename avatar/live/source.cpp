#include "avatar/live/source.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "avatar/live/blendshape_matrix.h"
#include "avatar/live/packet_input.h"
#include "avatar/live/recording.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// A drive's scheme: how it is opened, and what of it is read.
struct Scheme {
  const char* name;
  PhoneParser parse;  // null: not an app of a phone
  bool asks;          // the app waits for requests
};
constexpr Scheme kSchemes[] = {{"udp", nullptr, false},
                               {"vmc", nullptr, false},
                               {"vts", ParseVtsFrame, true},
                               {"ifacialmocap", ParseIFacialMocapFrame, true},
                               {"livelink", ParseLiveLinkFrame, false}};

const Scheme& SchemeOf(const DriveAddress& address) {
  for (const Scheme& scheme : kSchemes)
    if (address.scheme == scheme.name) return scheme;
  throw Error(
      address.drive,
      "expected a file, a folder, webcam:, audio:, stdin:, udp://HOST:PORT, vmc://HOST:PORT, "
      "vts://PHONE, ifacialmocap://PHONE or livelink://HOST");
}

struct Query {
  std::string matrix;            // FILE of "matrix=FILE", or ""
  HeadAngles signs = {1, 1, 1};  // of a phone, "flip=AXES": -1 for each of x, y, z in AXES
};

// "", "matrix=FILE" or, of a phone, "flip=AXES" or "flip=AXES&matrix=FILE".
Query ParseQuery(const DriveAddress& address, bool phone) {
  constexpr std::string_view kMatrix = "matrix=", kFlip = "flip=", kAxes = "xyz";
  const auto fail = [&] {
    throw Error(address.drive,
                "?" + address.query,
                "expected " + address.scheme + "://HOST:PORT?matrix=FILE" +
                    (phone ? ", ?flip=AXES with some of xyz, or ?flip=AXES&matrix=FILE" : ""));
  };
  Query query;
  std::string_view rest = address.query;
  if (phone && rest.starts_with(kFlip)) {
    const size_t end = std::min(rest.find('&'), rest.size());
    for (const char axis : rest.substr(kFlip.size(), end - kFlip.size())) {
      const size_t i = kAxes.find(axis);
      if (i == kAxes.npos) fail();
      query.signs[i] = -1;
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (rest.empty()) return query;
  if (!rest.starts_with(kMatrix) || rest.size() == kMatrix.size()) fail();
  query.matrix = rest.substr(kMatrix.size());
  return query;
}

}  // namespace

void TakeScores(const BlendshapeScores& scores,
                const std::vector<std::string>& dropped,
                const BlendshapeIndex& index,
                const std::string& description,
                std::vector<float>& values,
                LiveCounts& counts) {
  values.assign(values.size(), 0.0f);
  for (const auto& [name, score] : scores)
    if (const int i = FindScore(index, name, counts.unused); i >= 0) values[size_t(i)] = score;
  for (const std::string& name : dropped) {
    ++counts.malformed;
    counts.unused.dropped.Count(name);
    counts.last_problem = description + ": blendshapes." + PrintableName(name) +
                          ": is not a score, a number from 0 to 1";
  }
}

ChosenMap ChooseBlendshapeMap(const std::string& matrix, const LiveSourceOptions& options) {
  if (!matrix.empty())
    return {ReadBlendshapeMatrix(matrix), std::filesystem::path(matrix).filename().string()};
  if (options.blendshapes) return {*options.blendshapes, "the avatar's own blendshape map"};
  if (options.flame && !options.flame->expression_names.empty())
    return {GeneralBlendshapeMap(options.flame), "the head's own directions, by ARKit's names"};
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

bool IsLiveDrive(const std::string& drive) {
  return drive == "stdin:" || IsProgramDrive(drive) || drive.find("://") != std::string::npos;
}

std::unique_ptr<LiveSource> OpenLiveSource(const std::string& drive,
                                           const LiveSourceOptions& options) {
  if (drive == "stdin:") return OpenLineSource(STDIN_FILENO, "standard input", options);
  if (IsProgramDrive(drive)) return OpenProgramSource(drive, options);
  if (drive.starts_with("audio:"))
    throw Error(drive,
                "is no drive here: `cosplat voice FILE -o FILE.csv` makes one of a sound file");
  if (drive.find("://") == std::string::npos) return OpenRecording(drive, options);
  const DriveAddress address = ParseDriveAddress(drive);
  const Scheme& scheme = SchemeOf(address);
  const Query query = ParseQuery(address, scheme.parse != nullptr);
  ChosenMap map = ChooseBlendshapeMap(query.matrix, options);
  auto input = scheme.asks ? OpenPhoneInput(address) : OpenUdpInput(address);
  if (scheme.parse)
    return OpenPhoneSource(std::move(input), scheme.parse, std::move(map), options, query.signs);
  const auto open = address.scheme == "udp" ? OpenJsonSource : OpenVmcSource;
  return open(std::move(input), std::move(map), options);
}

std::unique_ptr<LiveSource> OpenLineSource(int descriptor,
                                           const std::string& description,
                                           const LiveSourceOptions& options) {
  return OpenJsonSource(
      OpenLineInput(descriptor, description), ChooseBlendshapeMap("", options), options);
}

}  // namespace cosplat

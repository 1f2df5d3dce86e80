// Live faces: packets, lines and the matrix that maps their scores.
#include <unistd.h>

#include <memory>

#include "avatar/live/blendshape_matrix.h"
#include "avatar/live/json_frame.h"
#include "avatar/live/osc.h"
#include "avatar/live/recording.h"
#include "splat/base/error.h"
#include "tests/avatar/live/osc_builder.h"
#include "tests/avatar/live/phone_packets.h"
#include "tests/fuzz/live_check.h"
#include "tests/fuzz/reader.h"

namespace cosplat::test {
namespace {

using Strings = std::vector<std::string>;

constexpr int64_t kLiveStepNs = 600'000'000;  // beyond the pause after which any sequence is taken

Npz Matrix() {
  Npz npz("matrix.npz");
  npz.Add("expression", {52, 3}, std::vector<float>(52 * 3, 1.5f));
  npz.Add("jaw", {52, 3}, std::vector<float>(52 * 3, 0.01f));
  return npz;
}

std::string ReadMatrix(const std::string& folder, const std::string&) {
  return NotFinite(ReadBlendshapeMatrix(folder + "/matrix.npz").matrix);
}

// A source that lives as long as the process, as a drive does.
struct Drive {
  std::string packet;
  std::unique_ptr<LiveSource> source;
  int64_t now_ns = 0;

  std::string Problem(const std::string& bytes) {
    packet = bytes;
    bool good = false;
    const uint64_t malformed = source->Counts().malformed;
    const std::string problem = PollProblem(*source, now_ns += kLiveStepNs, good);
    if (problem.empty() && !good && source->Counts().malformed > malformed)
      throw Error("packet", source->Counts().last_problem);
    return problem;
  }
};

std::string ReadJsonPacket(const std::string&, const std::string& bytes) {
  static Drive drive;
  if (!drive.source)
    drive.source = OpenJsonSource(
        std::make_unique<MemoryInput>(&drive.packet), ChooseBlendshapeMap("", {}), {});
  return drive.Problem(bytes);
}

Strings JsonPackets() {
  JsonFrame frame;
  frame.sequence = 41;
  frame.time = 2.5;
  frame.params.expression = {0.5f, -1, 2, 0.25f};
  frame.params.pose[2] = {0.1f, 0, 0};
  return {WriteJsonFrame(frame),
          R"({"seq": 7})",
          R"({"seq": 8, "blendshapes": {"jawOpen": 0.5, "eyeBlinkLeft": 1, "other": -3}})",
          R"({"seq": 9, "time": 1e3, "eyes": [0.1, 0.2, 0.3], "jaw": [0, 0, 0]})"};
}

// What a pipe brings: lines of any length, cut anywhere.
std::string ReadLines(const std::string&, const std::string& bytes) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  std::string problem;
  const auto source =
      OpenJsonSource(OpenLineInput(ends[0], "pipe"), ChooseBlendshapeMap("", {}), {});
  bool good = false;
  for (size_t at = 0; at < bytes.size() && problem.empty();) {
    const size_t part = std::min<size_t>(bytes.size() - at, 1 + uint8_t(bytes[at]) * size_t(7));
    if (write(ends[1], bytes.data() + at, part) != ssize_t(part)) problem = "a full pipe";
    at += part;
    if (problem.empty()) problem = PollProblem(*source, 0, good);
  }
  close(ends[1]);
  if (problem.empty()) problem = PollProblem(*source, 0, good);
  if (problem.empty() && !source->Ended()) problem = "no end";
  close(ends[0]);
  const LiveCounts counts = source->Counts();
  if (problem.empty() && counts.malformed + counts.oversize > 0)
    throw Error("pipe", counts.last_problem);
  return problem;
}

Strings JsonLines() {
  std::string lines;
  for (const std::string& packet : JsonPackets()) lines += packet + "\n";
  return {lines};
}

std::string ReadVmcPacket(const std::string& folder, const std::string& bytes) {
  static Drive drive;
  if (!drive.source)
    drive.source = OpenVmcSource(std::make_unique<MemoryInput>(&drive.packet),
                                 ChooseBlendshapeMap(folder + "/matrix.npz", {}),
                                 {});
  return drive.Problem(bytes);
}

template <PhoneParser kParse>
std::string ReadPhonePacket(const std::string&, const std::string& bytes) {
  static Drive drive;
  if (!drive.source)
    drive.source = OpenPhoneSource(
        std::make_unique<MemoryInput>(&drive.packet), kParse, ChooseBlendshapeMap("", {}), {});
  return drive.Problem(bytes);
}

std::string ReadLiveLinkTable(const std::string& folder, const std::string&) {
  const Recording recording = LoadRecording(folder + "/take.csv", {});
  int64_t last = -1;
  for (const RecordedFrame& frame : recording.frames) {
    if (frame.timestep <= last) return "frames out of order";
    last = frame.timestep;
    if (const std::string problem = FrameProblem(frame.params); !problem.empty()) return problem;
  }
  return "";
}

std::string ReadOsc(const std::string&, const std::string& bytes) {
  std::vector<OscMessage> messages;
  ParseOsc(bytes, messages);
  for (const OscMessage& message : messages)
    if (message.arguments.size() > kMaxOscArguments) return "too many arguments";
  for (const OscMessage& message : messages)
    if (!message.problem.empty()) throw Error("packet", std::string(message.problem));
  return "";
}

Strings OscPackets() {
  const std::string value = VmcValue("jawOpen", 0.5f);
  const std::string bone = VmcBone("Head", {0, 0.6f, 0, 0.8f});
  return {value,
          bone,
          VmcApply(),
          OscBundle({value, bone, VmcApply()}),
          OscBundle({OscBundle({value}), OscText("/VMC/Ext/OK"), VmcApply()})};
}

}  // namespace

std::vector<FuzzedReader> LiveReaders() {
  const Strings osc = {
      "#bundle", "/VMC/Ext/Blend/Val", "/VMC/Ext/Bone/Pos", ",sf", ",b", "jawOpen"};
  const Strings json = {"\"seq\":",
                        "\"blendshapes\":",
                        "\"expression\":",
                        "NaN",
                        "1e999",
                        "null",
                        "\\u0000",
                        "[[[[",
                        "{\"a\":"};
  const auto vmc_matrix = [](const std::string& folder) { Matrix().Write(folder + "/matrix.npz"); };
  const auto files = Placing::kFiles;
  return {{"blendshape_matrix",
           Placing::kZip,
           {"matrix.npz"},
           ReadMatrix,
           [] { return NpzSeeds(Matrix()); },
           NpyWords()},
          {"json_packet", files, {}, ReadJsonPacket, JsonPackets, json},
          {"json_lines", files, {}, ReadLines, JsonLines, json},
          {"vmc_packet", files, {}, ReadVmcPacket, OscPackets, osc, vmc_matrix},
          {"vts_packet",
           files,
           {},
           ReadPhonePacket<ParseVtsFrame>,
           VtsSeeds,
           {"\"FaceFound\":", "\"BlendShapes\":[", "{\"k\":\"JawOpen\",\"v\":", "NaN", "1e999"}},
          {"ifacialmocap_packet",
           files,
           {},
           ReadPhonePacket<ParseIFacialMocapFrame>,
           IFacialMocapSeeds,
           {"jawOpen-", "jawOpen&", "|=head#", "--", "nan", "1e999"}},
          {"livelink_packet",
           files,
           {},
           ReadPhonePacket<ParseLiveLinkFrame>,
           LiveLinkSeeds,
           {std::string("\x06\0\0\0", 4), "\x3d", "\x7f\x80"}},
          {"livelink_table",
           files,
           {"take.csv"},
           ReadLiveLinkTable,
           [] { return Strings{LiveLinkTable()}; },
           {"Timecode", "BlendShapeCount", "10:00:00:", "JawOpen", "\n", "nan", "1e999"}},
          {"osc", files, {}, ReadOsc, OscPackets, osc}};
}

}  // namespace cosplat::test

// Twenty thousand packets per protocol that are nearly good, under fixed seeds; COSPLAT_PACKETS
// says how many instead.
#include <gtest/gtest.h>

#include <cstdlib>

#include "avatar/live/json_frame.h"
#include "avatar/live/packet_input.h"
#include "splat/base/npz.h"
#include "tests/avatar/live/osc_builder.h"
#include "tests/avatar/live/phone_packets.h"
#include "tests/fuzz/live_check.h"
#include "tests/fuzz/mutate.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::MemoryInput;

int Packets() {
  const char* told = std::getenv("COSPLAT_PACKETS");
  return told ? std::atoi(told) : 20'000;
}
const int kPackets = Packets();
constexpr int64_t kStepNs = 600'000'000;  // beyond the pause after which any sequence is taken

struct Outcome {
  int good = 0, silent = 0;
  uint64_t malformed = 0;
};

// Sends mutations of `seeds` from `packet`, which the source reads.
Outcome SendMutations(LiveSource& source,
                      std::string& packet,
                      const std::vector<std::string>& seeds,
                      uint64_t seed) {
  Rng rng{seed};
  Outcome outcome;
  for (int i = 0; i < kPackets; ++i) {
    packet = test::Mutated(seeds[rng.Below(seeds.size())], seeds, rng);
    const uint64_t malformed = source.Counts().malformed;
    bool good = false;
    const std::string problem = test::PollProblem(source, i * kStepNs, good);
    EXPECT_EQ(problem, "") << testing::PrintToString(packet);
    outcome.good += good;
    outcome.silent += !good && source.Counts().malformed == malformed;
  }
  outcome.malformed = source.Counts().malformed;
  return outcome;
}

TEST(LiveMutations, OfJson) {
  JsonFrame frame;
  frame.sequence = 41;
  frame.time = 2.5;
  frame.params.expression = {0.5f, -1, 2, 0.25f};
  frame.params.pose[2] = {0.1f, 0, 0};
  const std::vector<std::string> seeds = {
      WriteJsonFrame(frame),
      R"({"seq": 7})",
      R"({"seq": 8, "blendshapes": {"jawOpen": 0.5, "eyeBlinkLeft": 1, "other": -3}})",
      R"({"seq": 9, "time": 1e3, "eyes": [0.1, 0.2, 0.3], "jaw": [0, 0, 0]})"};
  std::string packet;
  const auto source =
      OpenJsonSource(std::make_unique<MemoryInput>(&packet), ChooseBlendshapeMap("", {}), {});
  const Outcome outcome = SendMutations(*source, packet, seeds, 1);
  EXPECT_EQ(outcome.silent, 0);  // a packet either is a frame or is counted
  EXPECT_GT(outcome.good, kPackets / 50);
  EXPECT_GT(outcome.malformed, uint64_t(kPackets / 2));
}

// A packet of a phone's app is a frame, or is counted, or says that there is no face.
void SendPhoneMutations(PhoneParser parse, const std::vector<std::string>& seeds, uint64_t seed) {
  std::string packet;
  const auto source = OpenPhoneSource(
      std::make_unique<MemoryInput>(&packet), parse, ChooseBlendshapeMap("", {}), {});
  const Outcome outcome = SendMutations(*source, packet, seeds, seed);
  const LiveCounts counts = source->Counts();
  EXPECT_LE(uint64_t(outcome.silent), counts.unusable + counts.oversize);
  EXPECT_EQ(uint64_t(outcome.good), counts.frames);
  EXPECT_GT(outcome.good, kPackets / 50);
  EXPECT_GT(outcome.malformed, uint64_t(kPackets / 4));
}

TEST(LiveMutations, OfVts) { SendPhoneMutations(ParseVtsFrame, test::VtsSeeds(), 3); }

TEST(LiveMutations, OfIFacialMocap) {
  SendPhoneMutations(ParseIFacialMocapFrame, test::IFacialMocapSeeds(), 4);
}

TEST(LiveMutations, OfLiveLink) {
  SendPhoneMutations(ParseLiveLinkFrame, test::LiveLinkSeeds(), 5);
}

TEST(LiveMutations, OfVmc) {
  const test::TemporaryFolder folder;
  Npz npz(folder / "matrix.npz");
  npz.Add("expression", {52, 3}, std::vector<float>(52 * 3, 1.5f));
  npz.Add("jaw", {52, 3}, std::vector<float>(52 * 3, 0.01f));
  npz.Write(npz.path());
  const std::string value = test::VmcValue("jawOpen", 0.5f);
  const std::string bone = test::VmcBone("Head", {0, 0.6f, 0, 0.8f});
  const std::vector<std::string> seeds = {
      value,
      bone,
      test::VmcApply(),
      test::OscBundle({value, bone, test::VmcApply()}),
      test::OscBundle({test::OscBundle({value}), test::OscText("/VMC/Ext/OK"), test::VmcApply()})};
  std::string packet;
  const auto source = OpenVmcSource(
      std::make_unique<MemoryInput>(&packet), ChooseBlendshapeMap(npz.path(), {}), {});
  const Outcome outcome = SendMutations(*source, packet, seeds, 2);
  EXPECT_GT(outcome.good, kPackets / 50);
  EXPECT_GT(outcome.malformed, uint64_t(kPackets / 2));
}

}  // namespace
}  // namespace cosplat

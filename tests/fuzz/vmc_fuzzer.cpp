// libFuzzer on the packets of a VMC source.
#include <cstdint>
#include <cstdlib>

#include "avatar/live/packet_input.h"
#include "splat/base/npz.h"
#include "tests/fuzz/live_check.h"
#include "tests/support/temporary_folder.h"

namespace {

cosplat::ChosenMap MakeMatrix() {
  const cosplat::test::TemporaryFolder folder;
  cosplat::Npz npz(folder / "matrix.npz");
  npz.Add("expression", {52, 3}, std::vector<float>(52 * 3, 1.5f));
  npz.Add("jaw", {52, 3}, std::vector<float>(52 * 3, 0.01f));
  npz.Write(npz.path());
  return cosplat::ChooseBlendshapeMap(npz.path(), {});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cosplat;
  static std::string packet;
  static const std::unique_ptr<LiveSource> source =
      OpenVmcSource(std::make_unique<test::MemoryInput>(&packet), MakeMatrix(), {});
  packet.assign(reinterpret_cast<const char*>(data), size);
  bool good = false;
  if (!test::PollProblem(*source, 0, good).empty()) std::abort();
  return 0;
}

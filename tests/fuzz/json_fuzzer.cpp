// libFuzzer on the lines of a JSON source.
#include <cstdint>
#include <cstdlib>

#include "avatar/live/packet_input.h"
#include "tests/fuzz/live_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cosplat;
  static std::string packet;
  static const std::unique_ptr<LiveSource> source =
      OpenJsonSource(std::make_unique<test::MemoryInput>(&packet), ChooseBlendshapeMap("", {}), {});
  static int64_t now_ns = 0;
  packet.assign(reinterpret_cast<const char*>(data), size);
  bool good = false;
  if (!test::PollProblem(*source, now_ns += 600'000'000, good).empty()) std::abort();
  return 0;
}

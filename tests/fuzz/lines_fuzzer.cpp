// libFuzzer on what a pipe brings: lines of any length, cut anywhere.
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "avatar/live/packet_input.h"
#include "tests/fuzz/live_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cosplat;
  int ends[2];
  if (pipe(ends) != 0) std::abort();
  {
    const auto source =
        OpenJsonSource(OpenLineInput(ends[0], "pipe"), ChooseBlendshapeMap("", {}), {});
    bool good = false;
    for (size_t at = 0; at < size;) {
      const size_t part = std::min<size_t>(size - at, 1 + data[at] * size_t(7));
      if (write(ends[1], data + at, part) != ssize_t(part)) std::abort();
      at += part;
      if (!test::PollProblem(*source, 0, good).empty()) std::abort();
    }
    close(ends[1]);
    if (!test::PollProblem(*source, 0, good).empty() || !source->Ended()) std::abort();
  }
  close(ends[0]);
  return 0;
}

// libFuzzer on splat files: the first byte chooses a name, which decides between .splat and what is
// told by its first bytes.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/splat_check.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cosplat;
  static const test::TemporaryFolder folder;
  if (size == 0) return 0;
  bool good = false;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::string problem =
      test::SplatProblem(folder / (data[0] & 1 ? "a.splat" : "a"), bytes, good);
  if (!problem.empty()) {
    std::fprintf(stderr, "%s\n", problem.c_str());
    std::abort();
  }
  return 0;
}

// libFuzzer on one reader, which the environment names since libFuzzer's own arguments follow the
// program's:
//
//   COSPLAT_READER=NAME cosplat_fuzz_reader [LIBFUZZER'S ARGUMENTS]
//   COSPLAT_SEEDS=FOLDER cosplat_fuzz_reader    writes FOLDER/NAME/ and FOLDER/NAME.dict of each
//                                               reader, and ends
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "splat/base/files.h"
#include "tests/fuzz/reader.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace cosplat;  // NOLINT: a program

// A line of a dictionary: every byte in hexadecimal.
std::string QuotedWord(const std::string& word) {
  std::string line = "\"";
  for (const char c : word) {
    char byte[5];
    std::snprintf(byte, sizeof byte, "\\x%02x", unsigned(uint8_t(c)));
    line += byte;
  }
  return line + "\"\n";
}

void WriteSeeds(const std::string& folder) {
  for (const test::FuzzedReader& reader : test::FuzzedReaders()) {
    const std::string name = folder + "/" + reader.name;
    MakeDirectories(name);
    int i = 0;
    for (const std::string& seed : reader.seeds())
      WriteFileAtomically(name + "/seed_" + std::to_string(i++), seed);
    std::string words = QuotedWord(test::kPartMark);
    for (const std::string& word : reader.words) words += QuotedWord(word);
    WriteFileAtomically(name + ".dict", words);
  }
}

struct Chosen {
  test::TemporaryFolder folder;
  std::unique_ptr<test::ReaderRun> run;

  Chosen() {
    const char* const name = std::getenv("COSPLAT_READER");
    for (const test::FuzzedReader& reader : test::FuzzedReaders())
      if (name && reader.name == name)
        run = std::make_unique<test::ReaderRun>(reader, folder.path());
    if (run) return;
    std::fprintf(stderr, "COSPLAT_READER is '%s', not one of\n", name ? name : "");
    for (const auto& reader : test::FuzzedReaders())
      std::fprintf(stderr, "%s\n", reader.name.c_str());
    std::exit(2);
  }
};

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  if (const char* const folder = std::getenv("COSPLAT_SEEDS")) {
    WriteSeeds(folder);
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Chosen chosen;
  bool good = false;
  const std::string problem =
      chosen.run->Problem({reinterpret_cast<const char*>(data), size}, good);
  if (!problem.empty()) {
    std::fprintf(stderr, "%s\n", problem.c_str());
    std::abort();
  }
  return 0;
}

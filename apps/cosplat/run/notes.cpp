#include "apps/cosplat/run/notes.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "splat/base/error.h"
#include "splat/io/splat_file.h"

namespace cosplat {

Gaussians ReadSplatsAloud(const std::string& path) {
  std::vector<std::string> notes;
  Gaussians gaussians = ReadSplats(path, &notes);
  for (const std::string& note : notes)  // on one line, as errors are
    std::fprintf(stderr, "cosplat: %s\n", Error(path, note).what());
  return gaussians;
}

std::string ToString(const std::vector<Finding>& findings) {
  if (findings.empty()) return "check: the data tells one story\n";
  std::string text = "check:\n";
  for (const bool wrong : {true, false})
    for (const Finding& finding : findings)
      if (finding.wrong == wrong) text += (wrong ? "  WRONG: " : "  note: ") + finding.text + "\n";
  return text;
}

bool PrintFindings(const std::string& source,
                   const std::vector<Finding>& findings,
                   bool strict,
                   bool quiet) {
  const bool wrong = AnyWrong(findings);
  if (wrong || (!findings.empty() && !quiet))
    std::fprintf(stderr, "%s", ToString(findings).c_str());
  if (strict && wrong)
    throw Error(source, "check", "something is wrong with the data (above): --strict refuses it");
  return !wrong;
}

void EndAsWrong(const std::string& source) {
  std::fprintf(stderr,
               "cosplat: %s: check: the results are of data that is WRONG, as said before the "
               "first step (exit code %d)\n",
               source.c_str(),
               kSomethingWrong);
  throw CLI::RuntimeError(kSomethingWrong);
}

void PrintSkipped(const std::vector<SkippedFrame>& skipped) {
  if (skipped.empty()) return;
  std::printf("%zu frames skipped:\n", skipped.size());
  constexpr size_t kListed = 5;
  for (size_t i = 0; i < std::min(kListed, skipped.size()); ++i)
    std::printf("  %s: %s\n", skipped[i].name.c_str(), skipped[i].reason.c_str());
  if (skipped.size() > kListed) std::printf("  ... (all are in skipped_frames.json)\n");
}

}  // namespace cosplat

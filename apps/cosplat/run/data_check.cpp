#include "apps/cosplat/run/data_check.h"

#include <cstdio>

#include "splat/base/error.h"

namespace cosplat {

std::string ToString(const std::vector<Finding>& findings) {
  if (findings.empty()) return "check: the data tells one story\n";
  std::string text = "check:\n";
  for (const bool wrong : {true, false})
    for (const Finding& finding : findings)
      if (finding.wrong == wrong) text += (wrong ? "  WRONG: " : "  note: ") + finding.text + "\n";
  return text;
}

void PrintFindings(const std::string& source, const std::vector<Finding>& findings, bool strict) {
  if (!findings.empty()) std::fprintf(stderr, "%s", ToString(findings).c_str());
  if (strict && AnyWrong(findings))
    throw Error(source, "check", "something is wrong with the data (above): --strict refuses it");
}

}  // namespace cosplat

// What a check says, for its tests.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "splat/base/skipped.h"

namespace cosplat::test {

inline std::string Said(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& finding : findings)
    text += (finding.wrong ? "WRONG: " : "note: ") + finding.text + "\n";
  return text;
}

inline bool Wrong(const std::vector<Finding>& findings, const std::string& part) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& f) {
    return f.wrong && f.text.find(part) != std::string::npos;
  });
}

}  // namespace cosplat::test

#include "splat/base/skipped.h"

#include <algorithm>

#include "splat/base/error.h"

namespace cosplat {
namespace {

bool TooMany(size_t usable, size_t skipped) { return skipped * 3 > usable + skipped; }

}  // namespace

void CheckSkipped(const std::string& source,
                  size_t usable,
                  const std::vector<SkippedFrame>& skipped) {
  const size_t total = usable + skipped.size();
  if (usable > 0 && !TooMany(usable, skipped.size())) return;
  if (total == 0) throw Error(source, "contains no frames");
  std::string text = std::to_string(skipped.size()) + " of " + std::to_string(total) +
                     " frames cannot be used, at most a third may: ";
  constexpr size_t kShown = 3;
  for (size_t i = 0; i < std::min(skipped.size(), kShown); ++i)
    text += (i ? "; " : "") + skipped[i].name + ": " + skipped[i].reason;
  if (skipped.size() > kShown) text += "; ...";
  throw Error(source, text);
}

void NoteSkipped(size_t usable,
                 const std::vector<SkippedFrame>& skipped,
                 const std::string& what,
                 std::vector<Finding>& findings) {
  if (skipped.empty()) return;
  findings.push_back({TooMany(usable, skipped.size()),
                      std::to_string(skipped.size()) + " of " +
                          std::to_string(usable + skipped.size()) + " " + what +
                          " cannot be used and are left out (" + skipped.front().name + ": " +
                          skipped.front().reason + ")"});
}

}  // namespace cosplat

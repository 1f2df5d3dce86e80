#include "avatar/live/unused_input.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr size_t kMaxNameBytes = 48;
constexpr size_t kNamesShown = 6;
constexpr std::string_view kArkitNotInMap = "those of ARKit that move nothing by this map";

}  // namespace

std::string PrintableName(std::string_view name) {
  const Json text(std::string(name.substr(0, kMaxNameBytes)));
  const std::string quoted = text.dump(-1, ' ', true, Json::error_handler_t::ignore);
  return quoted.substr(1, quoted.size() - 2) + (name.size() > kMaxNameBytes ? "..." : "");
}

void NameCounts::Count(std::string_view name) {
  // One byte more, which says that it was cut.
  name = name.substr(0, kMaxNameBytes + 1);
  if (const auto found = counts_.find(name); found != counts_.end())
    ++found->second;
  else if (counts_.size() < kMaxNames)
    counts_.emplace(name, 1);
  else
    ++others_;
}

uint64_t NameCounts::Of(std::string_view name) const {
  const auto found = counts_.find(name);
  return found == counts_.end() ? 0 : found->second;
}

std::string NameCounts::Text() const {
  std::vector<std::pair<std::string, uint64_t>> names(counts_.begin(), counts_.end());
  std::stable_sort(
      names.begin(), names.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  uint64_t rest = others_;
  for (size_t i = 0; i < names.size(); ++i) {
    if (i >= kNamesShown) {
      rest += names[i].second;
      continue;
    }
    text += Format("{}{} ({})", i > 0 ? ", " : "", PrintableName(names[i].first), names[i].second);
  }
  return rest == 0 ? text : text + ", others (" + std::to_string(rest) + ")";
}

std::string UnusedInput::Text() const {
  std::string text;
  const auto add = [&](const char* kind, const NameCounts& names) {
    if (!names.empty()) text += (text.empty() ? "" : "; ") + (kind + names.Text());
  };
  add("ignored messages: ", messages);
  add("ignored blendshapes: ", blendshapes);
  add("ignored bones: ", bones);
  add("dropped: ", dropped);
  return text;
}

int FindScore(const BlendshapeIndex& index, std::string_view name, UnusedInput& unused) {
  const int place = index.Find(name);
  if (place < 0) unused.blendshapes.Count(FindArkitBlendshape(name) < 0 ? name : kArkitNotInMap);
  return place;
}

}  // namespace cosplat

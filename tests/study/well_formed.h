// Whether text is well-formed XML, as far as the project's own charts use it.
#pragma once

#include <regex>
#include <string>
#include <vector>

namespace cosplat::test {

// Empty, or what is wrong: tags that do not match, attributes without quotes, bare & or >.
inline std::string ProblemOfXml(const std::string& text) {
  static const std::regex tag("<(/?)([A-Za-z]+)((?: [A-Za-z0-9:-]+=\"[^\"<]*\")*)(/?)>");
  static const std::regex content("([^<>&]|&(amp|lt|gt|quot);)*");
  std::vector<std::string> open;
  size_t at = 0, roots = 0;
  while (at < text.size()) {
    const size_t next = std::min(text.find('<', at), text.size());
    if (!std::regex_match(text.substr(at, next - at), content))
      return "not text: " + text.substr(at, next - at);
    if (next == text.size()) break;
    std::smatch match;
    if (!std::regex_search(text.begin() + long(next),
                           text.end(),
                           match,
                           tag,
                           std::regex_constants::match_continuous))
      return "not a tag: " + text.substr(next, 60);
    const bool closes = match[1].length() > 0, empty = match[4].length() > 0;
    if (closes) {
      if (open.empty() || open.back() != match[2]) return "closes " + match[2].str();
      open.pop_back();
    } else if (!empty) {
      if (open.empty() && ++roots > 1) return "a second root: " + match[2].str();
      open.push_back(match[2]);
    }
    at = next + size_t(match.length());
  }
  return open.empty() ? "" : open.back() + " is not closed";
}

}  // namespace cosplat::test

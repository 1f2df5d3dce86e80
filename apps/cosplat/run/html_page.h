// Self-contained HTML pages about a run, all in one style.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "splat/base/image.h"

namespace cosplat {

// A whole page. title: text; body: HTML.
std::string HtmlPage(const std::string& title, const std::string& body);

// Rows of text: a name and a value each.
std::string HtmlTable(const std::vector<std::pair<std::string, std::string>>& rows);

// What a better video would show (AdviceFor), under a heading; empty if that is nothing.
std::string AdviceHtml(const std::vector<std::string>& advice);

// Up to `count` of `all`, evenly spread.
template <class T>
std::vector<T> Spread(const std::vector<T>& all, size_t count) {
  count = std::min(count, all.size());
  std::vector<T> spread;
  for (size_t i = 0; i < count; ++i)
    spread.push_back(all[count == 1 ? 0 : i * (all.size() - 1) / (count - 1)]);
  return spread;
}

// RFC 4648, with padding.
std::string Base64(const std::vector<uint8_t>& bytes);

// "data:image/png;base64,..." (RFC 2397), PNG or JPEG by `extension` (".png", ".jpg"). Throws Error
// as EncodeImage does.
std::string ImageUri(const Image8& image, const std::string& extension);

}  // namespace cosplat

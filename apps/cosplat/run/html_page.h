// Self-contained HTML pages about a run, all in one style.
#pragma once

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

// By a printf format for one double.
std::string FormatNumber(double value, const char* format);

// RFC 4648, with padding.
std::string Base64(const std::vector<uint8_t>& bytes);

// "data:image/png;base64,..." (RFC 2397), PNG or JPEG by `extension` (".png", ".jpg"). Throws Error
// as EncodeImage does.
std::string ImageUri(const Image8& image, const std::string& extension);

}  // namespace cosplat

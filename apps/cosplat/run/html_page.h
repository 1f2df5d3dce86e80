// Self-contained HTML pages about a run, all in one style.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace cosplat {

// A whole page. title: text; body: HTML.
std::string HtmlPage(const std::string& title, const std::string& body);

// Rows of text: a name and a value each.
std::string HtmlTable(const std::vector<std::pair<std::string, std::string>>& rows);

// By a printf format for one double.
std::string FormatNumber(double value, const char* format);

}  // namespace cosplat

#include "apps/cosplat/run/html_page.h"

#include <cstdio>

#include "apps/charts/svg_drawing.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr const char* kStyle =
    "<style>body{font:16px/1.5 system-ui,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;"
    "color:#222}h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em}th{text-align:left;"
    "font-weight:normal;padding-right:2em;color:#555}td{font-variant-numeric:tabular-nums}"
    ".pairs{display:grid;grid-template-columns:1fr 1fr;gap:12px}"
    ".many{display:grid;grid-template-columns:repeat(auto-fill,minmax(250px,1fr));gap:12px}"
    "figure{margin:0}img{max-width:100%}"
    "figcaption{color:#777;font-size:.85em}.row{display:flex;gap:3em;flex-wrap:wrap}"
    ".row svg{max-width:520px;height:auto;margin-top:2em}</style>";

}  // namespace

std::string HtmlPage(const std::string& title, const std::string& body) {
  return "<!doctype html><html lang='en'><meta charset='utf-8'><title>" + EscapeXml(title) +
         "</title>" + kStyle + body + "</html>\n";
}

std::string HtmlTable(const std::vector<std::pair<std::string, std::string>>& rows) {
  std::string html = "<table>";
  for (const auto& [name, value] : rows)
    html += "<tr><th>" + EscapeXml(name) + "</th><td>" + EscapeXml(value) + "</td></tr>";
  return html + "</table>";
}

std::string AdviceHtml(const std::vector<std::string>& advice) {
  if (advice.empty()) return "";
  std::string html = "<h2>What would make the avatar better</h2><ul>";
  for (const std::string& line : advice) html += "<li>" + EscapeXml(line) + "</li>";
  return html + "</ul>";
}

std::string Base64(const std::vector<uint8_t>& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
  }
  return out;
}

std::string ImageUri(const Image8& image, const std::string& extension) {
  const std::string type = extension == ".png" ? "image/png" : "image/jpeg";
  return "data:" + type + ";base64," + Base64(EncodeImage("image" + extension, image));
}

}  // namespace cosplat

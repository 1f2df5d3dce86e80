#include "apps/study/stability/stability_page.h"

#include <cmath>
#include <cstdio>

#include "apps/charts/chart_scale.h"
#include "apps/charts/svg_drawing.h"
#include "apps/cosplat/run/html_page.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr const char* kPageStyle =
    "<style>body{font:16px/1.5 system-ui,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;"
    "color:#222}h1{font-size:1.6em}h2{font-size:1.2em;margin:0 0 .3em}p{margin:.4em "
    "0;max-width:46em}"
    "section{border-top:1px solid #ddd;padding:1.2em 0}.forms{display:grid;"
    "grid-template-columns:1fr "
    "1fr;gap:1.5em;margin-top:.8em;max-width:760px}.form{display:flex;flex-direction:column;"
    "justify-content:flex-end}.form b{display:block;"
    "font-size:1.35em;font-variant-numeric:tabular-nums}.naive b{color:#b02a00}.ours "
    "b{color:#00724f}"
    ".form span,.bound,figcaption,.quantity{color:#555}img{display:block;margin-top:.5em;"
    "image-rendering:pixelated;border:1px solid #ddd}svg{width:100%;max-width:760px;height:auto;"
    "border:1px solid #ddd;margin-top:.8em}table{border-collapse:collapse;margin:1em 0}"
    "th,td{text-align:left;padding:.2em 1.2em .2em 0;border-bottom:1px solid #eee;"
    "font-weight:normal}td{font-variant-numeric:tabular-nums}td+td{white-space:nowrap}thead "
    "th{color:#555}"
    "a{color:inherit}</style>";

// 0.00123 -> "1.23e-3", 22003 -> "22,003"; non-finite values in words.
std::string ValueText(double value) {
  if (std::isnan(value)) return "not a number";
  if (std::isinf(value)) return "infinite";
  const double size = std::abs(value);
  char text[64];
  if (size == 0 || (size >= 1e-2 && size < 1e5)) {
    const bool whole = size >= 999.5;
    std::snprintf(text, sizeof text, whole ? "%.0f" : "%.3g", value);
    std::string digits = text;
    if (whole) digits.insert(digits.size() - 3, ",");
    return digits;
  }
  const int exponent = int(std::floor(std::log10(size)));
  std::snprintf(text, sizeof text, "%.3ge%d", value / std::pow(10.0, exponent), exponent);
  return text;
}
std::string WithUnit(double value, const std::string& unit) {
  const bool is_number = std::isfinite(value);
  return ValueText(value) + (unit.empty() || !is_number ? "" : " " + unit);
}
std::string BoundText(const StabilityCase& s) {
  if (s.bound == 0 && !s.at_least) return "0";
  return std::string(s.at_least ? "at least " : "at most ") + WithUnit(s.bound, s.unit);
}

std::string ImageHtml(const Image8& image, const std::string& about) {
  if (image.empty()) return "";
  // Enlarges small images by an integer factor.
  const int times = std::max(1, 320 / std::max(image.width, image.height));
  return "<img width=\"" + std::to_string(times * image.width) + "\" height=\"" +
         std::to_string(times * image.height) + "\" alt=\"" + EscapeXml(about) + "\" src=\"" +
         ImageUri(image, ".png") + "\"/>";
}

std::string FormHtml(const StabilityCase& s, const StabilityForm& form, const char* style) {
  return std::string("<div class=\"form ") + style + "\"><span>" + EscapeXml(form.name) +
         "</span><b>" + EscapeXml(WithUnit(form.value, s.unit)) + "</b>" +
         ImageHtml(form.image, s.title + ": " + form.name) + "</div>\n";
}

Chart ChartOf(const StabilityCase& s) {
  Chart chart;
  chart.title = s.title;
  chart.x = {s.chart.x_name, s.chart.x_unit, s.chart.x_log};
  chart.y = {s.chart.y_name, s.chart.y_unit, s.chart.y_log};
  for (const StabilityCurve& curve : s.chart.curves) {
    ChartSeries series{curve.name, {}};
    for (const auto& [x, y] : curve.points) series.marks.push_back({x, y, ""});
    chart.series.push_back(series);
  }
  return chart;
}

std::string CaseHtml(const StabilityCase& s) {
  const bool holds = IsWithinBound(s, s.ours.value);
  std::string html = "<section id=\"" + EscapeXml(s.key) + "\"><h2>" + EscapeXml(s.title) +
                     "</h2><p>" + EscapeXml(s.what) + "</p><p class=\"quantity\">" +
                     EscapeXml(s.quantity) + "</p><div class=\"forms\">" +
                     FormHtml(s, s.naive, "naive") + FormHtml(s, s.ours, "ours") +
                     "</div><p class=\"bound\">A test holds ours to " + EscapeXml(BoundText(s)) +
                     (holds ? "" : "; it is not kept here") + ".</p>";
  if (!s.chart.curves.empty()) html += ToSvg(ChartOf(s));
  return html + "</section>\n";
}

std::string Summary(const std::vector<StabilityCase>& cases) {
  std::string html =
      "<table><thead><tr><th>What fails</th><th>Measured</th><th>Naive</th><th>Ours</th>"
      "<th>Bound</th></tr></thead><tbody>\n";
  for (const StabilityCase& s : cases)
    html += "<tr><th><a href=\"#" + EscapeXml(s.key) + "\">" + EscapeXml(s.title) +
            "</a></th><td>" + EscapeXml(s.quantity) + "</td><td>" +
            EscapeXml(ValueText(s.naive.value)) + "</td><td>" + EscapeXml(ValueText(s.ours.value)) +
            "</td><td>" + EscapeXml(BoundText(s)) + "</td></tr>\n";
  return html + "</tbody></table>\n";
}

nlohmann::ordered_json Finite(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}
nlohmann::ordered_json ToJson(const StabilityCase& s) {
  nlohmann::ordered_json json{{"key", s.key},
                              {"title", s.title},
                              {"what", s.what},
                              {"quantity", s.quantity},
                              {"unit", s.unit},
                              {"naive", {{"name", s.naive.name}, {"value", Finite(s.naive.value)}}},
                              {"ours", {{"name", s.ours.name}, {"value", Finite(s.ours.value)}}},
                              {"bound", Finite(s.bound)},
                              {"bound_is", s.at_least ? "at least" : "at most"},
                              {"ours_within_bound", IsWithinBound(s, s.ours.value)}};
  for (const StabilityCurve& curve : s.chart.curves) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    for (const auto& [x, y] : curve.points) points.push_back({Finite(x), Finite(y)});
    json["curves"].push_back({{"name", curve.name}, {"points", points}});
  }
  return json;
}

}  // namespace

Chart FormsChart(const std::vector<BasisForm>& forms) {
  Chart chart;
  chart.title = "Colour of degree 0 to 6: error against time";
  chart.x = {"time per colour, one core", "ns", true};
  chart.y = {"largest error against long double", "", true};
  for (const BasisForm& form : forms) {
    ChartSeries series{form.name, {}};
    for (const BasisFormPoint& p : form.points)
      series.marks.push_back({p.ns, p.error, std::to_string(p.degree)});
    chart.series.push_back(series);
  }
  return chart;
}

std::string StabilityHtml(const StabilityResults& results) {
  std::string html =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Where splatting "
      "fails</title>" +
      std::string(kPageStyle) +
      "<h1>Where splatting fails</h1><p>Each way in which splatting is known to fail: the naive "
      "form, as papers or released code have it, beside ours. Magenta in a image is what is not "
      "a number.</p>\n" +
      Summary(results.cases) +
      "<section><h2>Accuracy against time</h2><p>Ways to evaluate a "
      "Gaussian's colour, a point per degree, on " +
      EscapeXml(results.machine) +
      ". Lower is more accurate, further left is faster. Behind the plane u_x = 0, arctan(y/x) is "
      "another function.</p>" +
      ToSvg(FormsChart(results.forms)) + "</section>\n";
  for (const StabilityCase& s : results.cases) html += CaseHtml(s);
  return html + "</html>\n";
}

nlohmann::ordered_json StabilityJson(const StabilityResults& results) {
  nlohmann::ordered_json json{{"machine", results.machine}};
  json["forms"] = nlohmann::ordered_json::array();
  for (const BasisForm& form : results.forms) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    for (const BasisFormPoint& p : form.points)
      points.push_back({{"degree", p.degree}, {"error", Finite(p.error)}, {"ns", p.ns}});
    json["forms"].push_back({{"name", form.name}, {"points", points}});
  }
  json["cases"] = nlohmann::ordered_json::array();
  for (const StabilityCase& s : results.cases) json["cases"].push_back(ToJson(s));
  return json;
}

}  // namespace cosplat

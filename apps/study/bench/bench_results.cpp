#include "apps/study/bench/bench_results.h"

#include "apps/charts/svg_drawing.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

OrderedJson ToJson(const Axis& axis) { return {{"name", axis.name}, {"unit", axis.unit}}; }

OrderedJson ToJson(const BenchSeries& s) {
  const bool bars = s.chart.kind == Chart::Kind::kBars;
  OrderedJson json{{"title", s.chart.title}, {"statistic", s.statistic}};
  if (bars)
    json["value"] = ToJson(s.chart.x);
  else
    json["x"] = ToJson(s.chart.x), json["y"] = ToJson(s.chart.y);
  json["series"] = OrderedJson::array();
  for (const ChartSeries& series : s.chart.series) {
    OrderedJson points = OrderedJson::array();
    for (const Mark& mark : series.marks) {
      OrderedJson point = OrderedJson::object();
      if (!mark.label.empty()) point["label"] = mark.label;
      if (bars)
        point["value"] = mark.x;
      else
        point["x"] = mark.x, point["y"] = mark.y;
      points.push_back(point);
    }
    json["series"].push_back({{"name", series.name}, {"points", points}});
  }
  json.update(s.more);
  return json;
}

constexpr const char* kPageStyle =
    "<style>body{font:16px/1.5 system-ui,sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;"
    "color:#222}main{display:grid;grid-template-columns:repeat(auto-fit,minmax(480px,1fr));gap:2em}"
    "figure{margin:0}svg{width:100%;height:auto;border:1px solid #ddd}figcaption{color:#555}"
    "</style>";

std::string Page(const OrderedJson& head, const std::vector<BenchSeries>& series) {
  const std::string machine = head["cpu"].get<std::string>() + ", " +
                              head["simd"].get<std::string>() + ", " + head["threads"].dump() +
                              " threads";
  std::string html =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>cosplat-study "
      "bench</title>" +
      std::string(kPageStyle) + "<h1>cosplat-study bench</h1><p>" + EscapeXml(machine) +
      "</p><main>\n";
  for (const BenchSeries& s : series)
    html += "<figure>" + ToSvg(s.chart) + "<figcaption>" + EscapeXml(s.explanation) +
            "</figcaption></figure>\n";
  return html + "</main></html>\n";
}

}  // namespace

void WriteBench(const std::string& folder,
                const OrderedJson& head,
                const std::vector<BenchSeries>& series) {
  OrderedJson json = head;
  for (const BenchSeries& s : series) {
    json[s.key] = ToJson(s);
    WriteFileAtomically(folder + "/" + s.key + ".svg", ToSvg(s.chart));
  }
  WriteFileAtomically(folder + "/index.html", Page(head, series));
  WriteFileAtomically(folder + "/bench.json", json.dump(2) + "\n");
}

}  // namespace cosplat

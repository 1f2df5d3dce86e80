#include "apps/study/runs/study_page.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "apps/charts/svg_drawing.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr const char* kStyle =
    "<style>body{font:16px/1.5 system-ui,sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;"
    "color:#222}.charts{display:grid;grid-template-columns:repeat(auto-fit,minmax(480px,1fr));"
    "gap:1em}svg{width:100%;height:auto;border:1px solid #ddd}h2{margin-top:2em;border-bottom:1px "
    "solid #ddd}.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.85em;margin:1em 0}"
    "th,td{padding:.15em .8em;text-align:right;white-space:nowrap;font-variant-numeric:"
    "tabular-nums}th{font-weight:normal;color:#555;border-bottom:1px solid #ddd}td:first-child,"
    "th:first-child{text-align:left}summary{cursor:pointer;color:#0072b2;margin:.5em 0}"
    "caption{text-align:left;font-weight:bold}.note{color:#555}</style>\n";

std::string Cell(const std::string& text, const char* tag = "td") {
  return std::string("<") + tag + ">" + EscapeXml(text) + "</" + tag + ">";
}

std::string HeadOf(const StudyFigure& figure) {
  return figure.unit.empty() ? figure.name : figure.name + ", " + figure.unit;
}

class Table {
 public:
  Table(const std::string& caption, const std::vector<std::string>& heads) {
    html_ = "<div class=\"wide\"><table><caption>" + EscapeXml(caption) + "</caption><tr>";
    for (const std::string& head : heads) html_ += Cell(head, "th");
    html_ += "</tr>\n";
  }
  void Row(const std::vector<std::string>& cells) {
    html_ += "<tr>";
    for (const std::string& cell : cells) html_ += Cell(cell);
    html_ += "</tr>\n";
    ++rows_;
  }
  // Empty if it has no rows.
  std::string Html() const { return rows_ > 0 ? html_ + "</table></div>\n" : ""; }

 private:
  std::string html_;
  size_t rows_ = 0;
};

std::vector<StudyFigure> ColumnsAt(const std::vector<StudyPoint>& points, int iterations) {
  std::vector<StudyFigure> columns = QualitiesIn(points);
  for (const StudyFigure& cost : CostsIn(points)) columns.push_back(cost);
  columns.push_back({"sog_psnr", "PSNR of the SOG", "dB", 2});
  columns.push_back({"mean_degree", "mean degree", "", 2});
  columns.push_back({"seconds", "wall clock", "s", 1});
  columns.push_back({"peak_mb", "peak memory", "MB", 0});
  const auto absent = [&](const StudyFigure& figure) {
    return std::none_of(points.begin(), points.end(), [&](const StudyPoint& point) {
      return point.At(figure.key, iterations).has_value();
    });
  };
  columns.erase(std::remove_if(columns.begin(), columns.end(), absent), columns.end());
  return columns;
}

std::string TableAt(const std::vector<StudyPoint>& points, int iterations) {
  const std::vector<StudyFigure> columns = ColumnsAt(points, iterations);
  std::vector<std::string> heads{"setting", "seeds"};
  for (const StudyFigure& column : columns) heads.push_back(HeadOf(column));
  Table table("At step " + WithThousands(size_t(iterations)), heads);
  for (const StudyPoint& point : points) {
    const auto any = point.At("PSNR", iterations);
    if (!any) continue;
    std::vector<std::string> cells{point.name, std::to_string(any->count)};
    for (const StudyFigure& column : columns)
      cells.push_back(ToString(point.At(column.key, iterations), column.decimals));
    table.Row(cells);
  }
  return table.Html();
}

// Over all data sets: settings minus those that they are compared with, paired by seed.
std::string DifferencesTable(const std::vector<StudyPoint>& points) {
  const std::vector<StudyFigure> qualities = QualitiesIn(points);
  std::vector<std::string> heads{"data", "difference", "seeds"};
  for (const StudyFigure& quality : qualities) heads.push_back("Δ " + HeadOf(quality));
  Table table("Finished models, mean over seeds of the difference ± its standard error", heads);
  for (const StudyPoint& point : points)
    for (const std::string& name : point.lines.back().minus)
      for (const StudyPoint& other : points) {
        if (other.data != point.data || other.name != name) continue;
        const auto psnr = PairedDifference(point, other, "PSNR");
        std::vector<std::string> cells{
            point.data, point.name + " − " + name, std::to_string(psnr ? psnr->count : 0)};
        for (const StudyFigure& quality : qualities)
          cells.push_back(
              SignedText(PairedDifference(point, other, quality.key), quality.decimals));
        table.Row(cells);
      }
  return table.Html();
}

// Distinct names in order of first appearance.
template <class F>
std::vector<std::string> InOrder(const std::vector<StudyPoint>& points, const F& names_of) {
  std::vector<std::string> all;
  for (const StudyPoint& point : points)
    for (const std::string& name : names_of(point))
      if (std::find(all.begin(), all.end(), name) == all.end()) all.push_back(name);
  return all;
}

// Finished models of each data set, then what others have published for it; and the means of all
// that have every data set. Empty if nothing is published.
std::vector<std::vector<std::string>> BesidePublished(const std::vector<StudyPoint>& measured,
                                                      const std::vector<StudyPoint>& published) {
  if (published.empty()) return {};
  std::vector<StudyPoint> all = measured;
  all.insert(all.end(), published.begin(), published.end());
  const auto data_of = [](const StudyPoint& p) { return std::vector<std::string>{p.data}; };
  const std::vector<std::string> sets = InOrder(measured, data_of);
  std::vector<StudyFigure> figures = QualitiesIn(all);
  figures.push_back({"gaussians", "Gaussians", "", 0});
  std::vector<std::vector<std::string>> rows{{"data", "system"}};
  for (const StudyFigure& figure : figures) rows[0].push_back(HeadOf(figure));
  const auto name_of = [](const StudyPoint& point) {
    return point.name + (point.lines[0].published() ? " (published)" : "");
  };
  for (const std::string& data : sets)
    for (const StudyPoint& point : all) {
      if (point.data != data) continue;
      rows.push_back({data, name_of(point)});
      for (const StudyFigure& figure : figures)
        rows.back().push_back(ToString(point.At(figure.key), figure.decimals));
    }
  const auto names_of = [&](const StudyPoint& p) { return std::vector<std::string>{name_of(p)}; };
  for (const std::string& name : InOrder(all, names_of)) {
    std::vector<std::string> cells{Format("mean of {}", sets.size()), name};
    bool any = false;
    for (const StudyFigure& figure : figures) {
      std::vector<double> means;
      for (const StudyPoint& point : all)
        if (const auto mean = point.At(figure.key); mean && name_of(point) == name)
          means.push_back(mean->mean);
      const bool whole = sets.size() > 1 && means.size() == sets.size();
      any = any || whole;
      Estimate mean = EstimateOf(means);
      mean.count = 1;  // the scatter of data sets is no error
      cells.push_back(whole ? ToString(mean, figure.decimals) : "-");
    }
    if (any) rows.push_back(cells);
  }
  return rows;
}

std::vector<StudyPoint> PointsIn(const std::vector<StudyPoint>& all,
                                 const std::string& data,
                                 const std::string& group) {
  std::vector<StudyPoint> points;
  for (const StudyPoint& point : all)
    if (point.data == data &&
        std::find(point.groups.begin(), point.groups.end(), group) != point.groups.end())
      points.push_back(point);
  return points;
}

// One group of one data set. The charts of the first metric are expanded, the others collapsed.
std::string GroupHtml(const std::vector<StudyPoint>& points,
                      const std::string& group,
                      const std::string& charts_folder) {
  std::string html = "<h3>" + EscapeXml(group) + "</h3>\n";
  const std::vector<StudyFigure> qualities = QualitiesIn(points);
  for (const StudyFigure& quality : qualities) {
    html += std::string("<details") + (&quality == &qualities[0] ? " open" : "") + "><summary>" +
            EscapeXml(quality.name) + "</summary><div class=\"charts\">\n";
    for (const StudyChart& chart : StudyCharts(points, group, quality)) {
      const std::string svg = ToSvg(chart.chart);
      html += svg;
      if (!charts_folder.empty())
        WriteFileAtomically(charts_folder + "/" + chart.key + ".svg", svg);
    }
    html += "</div></details>\n";
  }
  std::set<int> iterations;
  for (const StudyPoint& point : points) iterations.merge(point.Iterations());
  for (const int iteration : iterations) html += TableAt(points, iteration);
  return html;
}

std::string Joined(const std::set<std::string>& texts) {
  std::string line;
  for (const std::string& text : texts) line += (line.empty() ? "" : ", ") + text;
  return line;
}

// Caveats for comparing the figures.
std::string Notes(const StudyLines& all) {
  std::set<std::string> cpus, versions;
  for (const StudyLine& line : all.lines) {
    cpus.insert(line.cpu);
    versions.insert(line.version);
  }
  std::string html =
      "<p>" + std::to_string(all.lines.size()) + " runs, cosplat " + EscapeXml(Joined(versions)) +
      ", on " + EscapeXml(Joined(cpus)) +
      ". Points are means over seeds, bars one standard error either way; where "
      "there is one seed there is no bar, and small differences mean nothing. "
      "Ringed: the Pareto front, settings that no other beats in both figures of a chart.</p>\n";
  if (cpus.size() > 1)
    html +=
        "<p class=\"note\">The runs are of several machines: seconds and frames per second "
        "do not compare between them.</p>\n";
  if (!all.replaced.empty())
    html += "<p class=\"note\">Measured more than once, of which the later line counts: " +
            EscapeXml(Joined({all.replaced.begin(), all.replaced.end()})) + ".</p>\n";
  return html;
}

// The command of every setting, to reproduce a line of a table.
std::string CommandsHtml(const std::vector<StudyPoint>& points) {
  std::string html = "<h2>Commands</h2><details><summary>of the first seed</summary>\n<pre>";
  for (const StudyPoint& point : points) html += EscapeXml(point.lines[0].command) + "\n";
  return html + "</pre></details>\n";
}

std::string Page(const StudyLines& all,
                 const std::vector<std::vector<std::string>>& beside_published,
                 const std::string& charts_folder) {
  const std::vector<StudyPoint> points = PointsOf(all.lines);
  const auto data_of = [](const StudyPoint& p) { return std::vector<std::string>{p.data}; };
  const auto groups_of = [](const StudyPoint& p) { return p.groups; };
  std::string html =
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>cosplat-study</title>" +
      std::string(kStyle) + "<h1>cosplat-study</h1>" + Notes(all);
  if (!beside_published.empty()) {
    Table table("Finished models; others as they were published, on other machines",
                beside_published[0]);
    for (size_t i = 1; i < beside_published.size(); ++i) table.Row(beside_published[i]);
    html += "<h2>Beside published figures</h2>" + table.Html();
  }
  const std::string differences = DifferencesTable(points);
  if (!differences.empty()) html += "<h2>Differences</h2>" + differences;
  for (const std::string& data : InOrder(points, data_of)) {
    html += "<h2>" + EscapeXml(data) + "</h2>\n";
    for (const std::string& group : InOrder(points, groups_of)) {
      const std::vector<StudyPoint> here = PointsIn(points, data, group);
      if (!here.empty()) html += GroupHtml(here, group, charts_folder);
    }
  }
  return html + CommandsHtml(points) + "</html>\n";
}

}  // namespace

void WriteStudyPage(const std::string& folder, const std::string& charts) {
  StudyLines all = ReadStudyLines(folder);
  const auto published = std::stable_partition(
      all.lines.begin(), all.lines.end(), [](const StudyLine& line) { return !line.published(); });
  const std::vector<StudyLine> of_others(published, all.lines.end());
  all.lines.erase(published, all.lines.end());
  if (all.lines.empty()) throw Error(folder, "contains no finished run (*.jsonl)");
  if (!charts.empty()) MakeDirectories(charts);
  const auto beside = BesidePublished(PointsOf(all.lines), PointsOf(of_others));
  WriteFileAtomically(folder + "/index.html", Page(all, beside, charts));
  for (size_t i = 0; i < beside.size(); ++i) {
    std::string line = "|", rule = "|";
    for (const std::string& cell : beside[i]) line += " " + cell + " |", rule += "---|";
    std::printf("%s\n%s", line.c_str(), i == 0 ? (rule + "\n").c_str() : "");
  }
}

}  // namespace cosplat

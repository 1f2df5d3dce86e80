// What `cosplat bench` has measured, and how it is written: bench.json, a chart per series and a
// page that shows them all.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/study/charts/svg_chart.h"
#include "splat/base/json.h"

namespace cosplat {

using OrderedJson = nlohmann::ordered_json;

// One chart: bench.json has it under `key`, and <key>.svg draws it.
struct BenchSeries {
  std::string key;
  std::string explanation;  // one sentence: what the chart shows and how to read it
  std::string statistic;    // how several readings became one number
  Chart chart;
  OrderedJson more = OrderedJson::object();  // further figures that belong to it
};

// How much is measured, and who is told.
struct BenchRun {
  bool quick = false;
  std::function<void(const std::string& detail)> progress;
};

// Writes <folder>/<key>.svg of each, index.html, and last bench.json: `head`, then the series.
void WriteBench(const std::string& folder,
                const OrderedJson& head,
                const std::vector<BenchSeries>& series);

}  // namespace cosplat

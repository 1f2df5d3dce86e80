// Results of `cosplat-study bench` and their output: bench.json, one chart per series, and a page
// that shows all charts.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/charts/svg_chart.h"
#include "splat/base/json.h"

namespace cosplat {

using OrderedJson = nlohmann::ordered_json;

// One chart: stored in bench.json under `key` and drawn as <key>.svg.
struct BenchSeries {
  std::string key;
  std::string explanation;  // one sentence: what the chart shows and how to read it
  std::string statistic;    // how repeated measurements were reduced to one number
  Chart chart;
  OrderedJson more = OrderedJson::object();  // additional figures of this series
};

// Scope of the measurements and progress callback.
struct BenchRun {
  bool quick = false;
  std::function<void(const std::string& detail)> progress;
};

// Writes <folder>/<key>.svg of each series, index.html and finally bench.json: `head`, then the
// series.
void WriteBench(const std::string& folder,
                const OrderedJson& head,
                const std::vector<BenchSeries>& series);

}  // namespace cosplat

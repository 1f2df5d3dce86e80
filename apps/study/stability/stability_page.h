// What the stability suite found, as a page and as JSON.
#pragma once

#include <string>
#include <vector>

#include "apps/study/charts/svg_chart.h"
#include "apps/study/stability/basis_forms.h"
#include "apps/study/stability/stability_case.h"
#include "splat/base/json.h"

namespace cosplat {

struct StabilityResults {
  std::string machine;  // that the times are of
  std::vector<BasisForm> forms;
  std::vector<StabilityCase> cases;
};

// Error against time, a curve per form, a point per degree.
Chart FormsChart(const std::vector<BasisForm>& forms);

// Self-contained.
std::string StabilityHtml(const StabilityResults& results);

// Values that are infinite or not a number are null.
nlohmann::ordered_json StabilityJson(const StabilityResults& results);

}  // namespace cosplat

// Results of the stability suite as a page and as JSON.
#pragma once

#include <string>
#include <vector>

#include "apps/charts/svg_chart.h"
#include "apps/study/stability/basis_forms.h"
#include "apps/study/stability/stability_case.h"
#include "splat/base/json.h"

namespace cosplat {

struct StabilityResults {
  std::string machine;  // on which the times were measured
  std::vector<BasisForm> forms;
  std::vector<StabilityCase> cases;
};

// Error against time, one curve per form, one point per degree.
Chart FormsChart(const std::vector<BasisForm>& forms);

// A self-contained page.
std::string StabilityHtml(const StabilityResults& results);

// Non-finite values become null.
nlohmann::ordered_json StabilityJson(const StabilityResults& results);

}  // namespace cosplat

#include "splat/train/prune/pruner.h"

#include <algorithm>

#include "splat/base/error.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

std::unique_ptr<Pruner> MakeNoPruner(const PruneSettings&, const PrunedRun&) { return nullptr; }

std::vector<PruneRule>& Rules() {
  static std::vector<PruneRule> rules{
      {.name = "none", .make = MakeNoPruner},
      {.name = "leave-one-out", .make = MakeLeaveOneOutPruner, .ranks = true},
      {.name = "dcsharp", .make = MakeDcsharpPruner, .ranks = true},
      {.name = "dcsharp-released"},  // where there is none: only cosplat-study has it
      {.name = "dcsharp-triangle", .make = MakeDcsharpPruner, .ranks = true, .group_floor = 1},
      {.name = "lightgaussian"},
      {.name = "compact"},
      {.name = "lp", .make = MakeLpPruner, .learns_mask = true},
      {.name = "speedy"},
      {.name = "opacity", .make = MakeOpacityPruner, .ranks = true},
      {.name = "random"}};
  return rules;
}

auto Position(const std::string& name) {
  return std::find_if(
      Rules().begin(), Rules().end(), [&](const PruneRule& rule) { return rule.name == name; });
}

}  // namespace

void RegisterPruneRule(const PruneRule& rule) {
  const auto at = Position(rule.name);
  if (at == Rules().end())
    Rules().push_back(rule);
  else
    *at = rule;
}

std::vector<std::string> PruneRuleNames() {
  std::vector<std::string> names;
  for (const PruneRule& rule : Rules())
    if (rule.make) names.push_back(rule.name);
  return names;
}

PruneRule FindPruneRule(const std::string& name) {
  const auto at = Position(name);
  if (at == Rules().end()) {
    std::string known;
    for (const std::string& one : PruneRuleNames()) known += (known.empty() ? "" : ", ") + one;
    throw Error("--prune", "'" + name + "' is not a pruning rule; known: " + known);
  }
  if (!at->make) throw Error("--prune " + name, "only cosplat-study has this rule (docs/study.md)");
  return *at;
}

std::unique_ptr<Pruner> MakePruner(const PruneSettings& s,
                                   const Schedule& schedule,
                                   int iterations,
                                   size_t gaussians) {
  const PruneRule rule = FindPruneRule(s.rule);
  if (s.target > 0 && !rule.ranks)
    throw Error("--prune-to " + std::to_string(s.target),
                "--prune " + rule.name + " does not support a target count");
  if (s.mask_weight > 0 && !rule.learns_mask)
    throw Error("--prune-lambda", "--prune " + rule.name + " does not learn a mask");
  PrunedRun run{schedule, iterations, gaussians};
  run.schedule.densify_until = std::min(schedule.densify_until, iterations);
  return rule.make(s, run);
}

}  // namespace cosplat

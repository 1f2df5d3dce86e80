#include "splat/train/prune/pruner.h"

#include <algorithm>
#include <array>

#include "splat/base/error.h"
#include "splat/train/prune/rules.h"

namespace cosplat {
namespace {

struct NamedRule {
  const char* name;
  PruneRule rule;
};

constexpr std::array<NamedRule, 11> kRules{{{"none", PruneRule::kNone},
                                            {"leave-one-out", PruneRule::kLeaveOneOut},
                                            {"dcsharp", PruneRule::kDcsharp},
                                            {"dcsharp-released", PruneRule::kDcsharpReleased},
                                            {"dcsharp-triangle", PruneRule::kDcsharpTriangle},
                                            {"lightgaussian", PruneRule::kLightGaussian},
                                            {"compact", PruneRule::kCompact},
                                            {"lp", PruneRule::kLp},
                                            {"speedy", PruneRule::kSpeedy},
                                            {"opacity", PruneRule::kOpacity},
                                            {"random", PruneRule::kRandom}}};

}  // namespace

std::string ToString(PruneRule rule) {
  for (const NamedRule& r : kRules)
    if (r.rule == rule) return r.name;
  return "";
}

PruneRule PruneRuleFromString(const std::string& text) {
  std::string known;
  for (const NamedRule& r : kRules) {
    if (text == r.name) return r.rule;
    known += (known.empty() ? "" : ", ") + std::string(r.name);
  }
  throw Error("prune", "'" + text + "' is not a pruning rule; known: " + known);
}

std::vector<std::string> PruneRuleNames() {
  std::vector<std::string> names;
  for (const NamedRule& r : kRules) names.push_back(r.name);
  return names;
}

bool LearnsMask(PruneRule rule) { return rule == PruneRule::kCompact || rule == PruneRule::kLp; }

bool WorksOnProcessorOnly(PruneRule rule) { return rule == PruneRule::kDcsharpReleased; }

std::unique_ptr<Pruner> MakePruner(const PruneSettings& s,
                                   const Schedule& run_schedule,
                                   int iterations,
                                   size_t gaussians) {
  Schedule schedule = run_schedule;
  schedule.densify_until = std::min(schedule.densify_until, iterations);
  const std::string name = "--prune " + ToString(s.rule);
  const bool ranks =
      !LearnsMask(s.rule) && s.rule != PruneRule::kNone && s.rule != PruneRule::kDcsharpReleased;
  if (s.target > 0 && !ranks)
    throw Error("--prune-to " + std::to_string(s.target),
                name + " does not support a target count");
  if (s.mask_weight > 0 && !LearnsMask(s.rule))
    throw Error("--prune-lambda", name + " does not learn a mask");
  switch (s.rule) {
    case PruneRule::kNone:
      return nullptr;
    case PruneRule::kLeaveOneOut:
      return MakeLeaveOneOutPruner(s, schedule, iterations);
    case PruneRule::kDcsharp:
    case PruneRule::kDcsharpTriangle:
      return MakeDcsharpPruner(s, schedule);
    case PruneRule::kDcsharpReleased:
      return MakeDcsharpReleasedPruner(schedule, gaussians);
    case PruneRule::kLightGaussian:
      return MakeLightGaussianPruner(s, iterations);
    case PruneRule::kCompact:
      return MakeCompactPruner(s, schedule, iterations, gaussians);
    case PruneRule::kLp:
      return MakeLpPruner(s, iterations);
    case PruneRule::kSpeedy:
      return MakeSpeedyPruner(s, iterations);
    case PruneRule::kOpacity:
      return MakeOpacityPruner(s, schedule);
    case PruneRule::kRandom:
      return MakeRandomPruner(s, schedule);
  }
  return nullptr;
}

}  // namespace cosplat

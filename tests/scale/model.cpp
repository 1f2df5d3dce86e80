#include "tests/scale/model.h"

#include <algorithm>
#include <cmath>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/render/kernels/world_gaussians.h"
#include "splat/train/ranks/view_exchange.h"
#include "tests/support/rank_traffic.h"

namespace cosplat::scale {
namespace {

// Floats per Gaussian at degree 3: of bands >= 1, all, and what density control is told with
// three statistics.
constexpr double kRest = 45, kNumbers = 59, kAssembled = kNumbers - kRest + 3;
// Of a density control: children are added, Gaussians removed, all sorted. A Gaussian then has
// another owner, as if drawn at random, at most.
constexpr double kReorderings = 3;

double GroupsOf(double gaussians) { return gaussians / double(kGaussianGroup); }

}  // namespace

Measured MeasuredIn(const std::string& stats_json, double pixels) {
  const std::vector<char> bytes = ReadFile(stats_json);
  const Json json = ParseJson(stats_json, std::string(bytes.begin(), bytes.end()));
  const JsonField stats(stats_json, json);
  const JsonField batch = stats["batch"];
  if (batch["ranks"].Integer() != 1)
    throw Error(stats_json, "batch.ranks", "is not 1: the model is measured on one rank");
  const double steps = batch["steps"].Number(), views = batch["views"].Number();
  const double busy = stats["cpu_seconds"].Number() / stats["seconds"].Number();
  const auto seconds = [&](const char* phase) {  // of the whole run
    return busy * 1e-3 * steps * stats["phases_ms"][phase].Number();
  };
  Measured m;
  m.gaussians = stats["gaussians"].Number();
  m.pixels = pixels;
  m.batch = views / steps;
  const double drawn = batch["groups_drawn"].Number() * double(kGaussianGroup);
  const double updated = batch["groups_updated"].Number() * double(kGaussianGroup);
  m.drawn = drawn / (views * m.gaussians);
  m.updated = updated / (steps * m.gaussians);
  m.per_gaussian = seconds("project") / (views * m.gaussians);
  m.per_drawn = seconds("sort") / drawn;
  m.per_pixel = (seconds("blend") + seconds("loss") + seconds("backward")) / (views * pixels);
  m.per_summed = seconds("density") / drawn;
  m.per_updated = seconds("adam") / updated;
  return m;
}

Training TrainingOf(const Measured& m) {
  return {m.gaussians, m.pixels, m.batch, m.drawn * m.gaussians, m.updated * m.gaussians};
}

Training LargeTraining(const Measured& m, double gaussians, double batch) {
  constexpr double kControlEvery = 100;  // views
  const double drawn = std::min(m.drawn * gaussians, kMaxDrawn);
  const double updated = gaussians * (1 - std::pow(1 - drawn / gaussians, batch));
  // Adam has caught up before a density control.
  const double controlled = gaussians / std::max(1.0, kControlEvery / batch);
  return {gaussians,
          m.pixels,
          batch,
          drawn,
          updated + (1 - updated / gaussians) * controlled,
          kAssembled * controlled,
          (kRest + 2 * kNumbers) * kReorderings * controlled};
}

StepTime TimeOf(const Measured& m, const Training& t, const Machine& machine) {
  const double rounds = std::ceil(t.batch / machine.ranks);
  StepTime time;
  time.drawing = rounds * (m.per_drawn * t.drawn + m.per_pixel * t.pixels);
  time.own_share = (t.batch * (m.per_gaussian * t.gaussians + m.per_summed * t.drawn) +
                    m.per_updated * t.updated) /
                   machine.ranks;
  ExchangeStatistics counts;
  counts.ranks = size_t(machine.ranks);
  counts.views = uint64_t(t.batch);
  counts.groups_drawn = uint64_t(t.batch * GroupsOf(t.drawn));
  counts.assembled = uint64_t(t.assembled);
  counts.handed_over = uint64_t(t.moved * (1 - 1 / machine.ranks));
  time.bytes = TrafficOf(counts);
  // A rank's share of it. Of a round, three exchanges: lists, splats, gradients; of a step, one:
  // the losses. Each is a message for the length and one for the content.
  if (machine.ranks > 1)
    time.exchange = time.bytes / machine.ranks * (1 / kCopying + 1 / machine.bandwidth) +
                    2 * (3 * rounds + 1) * (machine.ranks - 1) * machine.latency;
  return time;
}

}  // namespace cosplat::scale

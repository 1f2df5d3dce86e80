// cosplat-study head-fit: how near our own head comes to people, whose faces another model makes.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/study/commands.h"
#include "apps/study/head_fit/surface_fit.h"
#include "assets/head/procedural_head.h"
#include "flame/pose.h"
#include "splat/base/rng.h"

namespace cosplat {
namespace {

struct HeadFitCommand {
  std::string people, model;
  int count = 200;
  unsigned seed = 0;
};

void Print(const char* what, const std::vector<FaceFit>& fits) {
  std::vector<double> all;
  double coefficient = 0;
  for (const FaceFit& fit : fits) {
    all.insert(all.end(), fit.distances.begin(), fit.distances.end());
    for (const double c : fit.coefficients)
      coefficient += c * c / double(fits.size() * fit.coefficients.size());
  }
  double mean = 0;
  for (const double d : all) mean += d / double(all.size());
  std::sort(all.begin(), all.end());
  std::printf("%-34s %.2f mm, 95 %% %.2f", what, 1e3 * mean, 1e3 * all[all.size() * 95 / 100]);
  if (coefficient > 0) std::printf(", coefficients %.2f RMS", std::sqrt(coefficient));
  std::printf("\n");
}

void MeasureHeadFit(const HeadFitCommand& o) {
  const FlameModel people = LoadFlameModel(o.people);
  const FlameModel ours = o.model.empty() ? MakeHeadForPeople() : LoadFlameModel(o.model);
  std::vector<std::vector<float>> faces{people.template_vertices};
  Rng rng{o.seed};
  for (int i = 0; i < o.count; ++i) {
    std::vector<float> shape;
    for (int k = 0; k < people.shape_count; ++k) shape.push_back(float(4 * rng.Uniform() - 2));
    FlamePoser<float>(people, shape).Forward({}, faces.emplace_back());
  }
  for (const bool with_shape : {false, true}) {
    std::vector<FaceFit> fits(faces.size());
    tbb::parallel_for(size_t(0), faces.size(), [&](size_t i) {
      fits[i] = FitToFace(ours, people, faces[i], with_shape);
    });
    const std::string how = with_shape ? ", with our shapes" : ", by turn, shift and size";
    Print(("the mean face" + how).c_str(), {fits[0]});
    fits.erase(fits.begin());
    if (o.count > 0) Print((std::to_string(o.count) + " people" + how).c_str(), fits);
  }
}

}  // namespace

void AddHeadFit(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "head-fit", "distance of our own head's face from people's, once it is fitted to them");
  const auto o = std::make_shared<HeadFitCommand>();
  command->add_option("people", o->people, "model with FLAME's mesh whose random shapes they are")
      ->required();
  command->add_option("--model", o->model, "head model in place of our own")->default_str("");
  command->add_option("--count", o->count, "of people, shapes uniform in -2 to 2")
      ->check(CLI::Range(0, 10000));
  command->add_option("--seed", o->seed, "of the shapes");
  command->callback([o] { MeasureHeadFit(*o); });
}

}  // namespace cosplat

// cosplat-study: settings, data sets and seeds side by side, the stability suite, and this machine;
// and the trainers with rules of pruning for comparison.
#include "apps/cosplat/commands.h"
#include "apps/cosplat/program.h"
#include "apps/study/commands.h"
#include "apps/study/rules/rules.h"

int main(int argc, char** argv) {
  const auto declare = [](CLI::App& app) {
    cosplat::RegisterStudyRules();
    cosplat::DeclareStudy(app);
    cosplat::AddBench(app);
    cosplat::AddFacePoints(app);
    cosplat::AddHeadFit(app);
    cosplat::AddMattes(app);
    cosplat::AddTrainAvatar(app);
    cosplat::AddTrainScene(app);
  };
  return cosplat::RunProgram("cosplat-study",
                             "Trains and measures settings, data sets and seeds side by side.",
                             declare,
                             argc,
                             argv);
}

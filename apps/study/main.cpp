// cosplat-study: settings, data sets and seeds side by side, the stability suite, and this machine.
#include "apps/cosplat/program.h"
#include "apps/study/commands.h"

int main(int argc, char** argv) {
  const auto declare = [](CLI::App& app) {
    cosplat::DeclareStudy(app);
    cosplat::AddBench(app);
  };
  return cosplat::RunProgram("cosplat-study",
                             "Trains and measures settings, data sets and seeds side by side.",
                             declare,
                             argc,
                             argv);
}

#include "apps/study/stability_command.h"

#include <cstdio>
#include <vector>

#include "apps/cosplat/run/progress_bar.h"
#include "apps/study/avatar_stability/stability.h"
#include "apps/study/bench/machine.h"
#include "apps/study/stability/stability.h"
#include "apps/study/stability/stability_page.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

void Append(std::vector<StabilityCase> more, std::vector<StabilityCase>& all) {
  for (StabilityCase& s : more) all.push_back(std::move(s));
}

}  // namespace

void WriteStabilityPage(const std::string& folder, bool quiet) {
  constexpr int kTimedBatches = 200;
  constexpr int kParts = 3;
  MakeDirectories(folder);
  StabilityResults results;
  results.machine = CpuName() + ", " + SimdTargets().at(0).name;
  {
    ProgressBar bar("stability", kParts, quiet);
    bar.Update(0, "forms of the basis");
    results.forms = MeasureBasisForms(kTimedBatches);
    bar.Update(1, "splats");
    Append(SplatStability(), results.cases);
    bar.Update(2, "avatars");
    Append(AvatarStability(), results.cases);
  }
  WriteFileAtomically(folder + "/basis_forms.svg", ToSvg(FormsChart(results.forms)));
  WriteFileAtomically(folder + "/stability.html",
                      StabilityHtml(results, folder + "/stability.tmp.png"));
  WriteFileAtomically(folder + "/stability.json", StabilityJson(results).dump(2) + "\n");
  if (!quiet) std::printf("%zu cases: %s/stability.html\n", results.cases.size(), folder.c_str());
}

}  // namespace cosplat

#include "apps/study/stability/stability.h"

#include "apps/study/stability/cases.h"

namespace cosplat {

std::vector<StabilityCase> SplatStability() {
  return {ArctanJump(),
          ThePole(),
          AnglesInFloat(),
          GradientOfAngles(),
          FormsOverTheSphere(),
          FrustumEdge(),
          OffCenterClamp(),
          DegenerateCovariance(),
          CameraCenter(),
          OpacitySaturation(),
          LastContributor(),
          Popping(),
          SumOrder(),
          Needles(),
          SsimOfConstants(),
          PairCount()};
}

}  // namespace cosplat

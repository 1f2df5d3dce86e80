// The stability cases of the renderer and trainer, one function each. For stability.cpp.
#pragma once

#include <vector>

#include "apps/study/stability/stability_case.h"

namespace cosplat {

// basis_cases.cpp
StabilityCase ArctanJump();
StabilityCase ThePole();
StabilityCase AnglesInFloat();
StabilityCase GradientOfAngles();
StabilityCase FormsOverTheSphere();

// projection_cases.cpp
StabilityCase FrustumEdge();
StabilityCase OffCenterClamp();
StabilityCase DegenerateCovariance();
StabilityCase CameraCenter();

// blending_cases.cpp
StabilityCase OpacitySaturation();
StabilityCase LastContributor();
StabilityCase Popping();
StabilityCase SumOrder();

// training_cases.cpp
StabilityCase Needles();
StabilityCase SsimOfConstants();
StabilityCase PairCount();

// The stability suite for splatting: known failure cases, the naive form compared with ours.
// docs/stability.md explains the cases.
//
// Returns all cases in display order. Takes some seconds; bit-identical on every run.
inline std::vector<StabilityCase> SplatStability() {
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

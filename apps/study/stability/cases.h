// The cases of the splat side, one function each. For stability.cpp.
#pragma once

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

}  // namespace cosplat

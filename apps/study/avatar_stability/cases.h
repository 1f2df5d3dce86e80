// The cases of AvatarStability, one function each, so that tests can run them one at a time.
#pragma once

#include "apps/study/avatar_stability/study_head.h"
#include "apps/study/stability/stability_case.h"

namespace cosplat {

// apps/study/avatar_stability/walk_cases.cpp
StabilityCase ParallelEdgeCase();
StabilityCase BentPathCase();
StabilityCase EndlessWalkCase(const StudyHead& head);

// apps/study/avatar_stability/boundary_case.cpp
StabilityCase BoundaryCase(const StudyHead& head);

// apps/study/avatar_stability/scale_cases.cpp
StabilityCase InverseScaleCase(const StudyHead& head);
StabilityCase UnitsCase(const StudyHead& head);

// apps/study/avatar_stability/expression_cases.cpp
StabilityCase ExpressionSizeCase(const StudyHead& head);
StabilityCase ExpressionReachCase(const StudyHead& head);
StabilityCase HolesCase(const StudyHead& head);

// apps/study/avatar_stability/surface_cases.cpp
StabilityCase OppositeRotationsCase(const StudyHead& head);
StabilityCase CollapsedFacesCase(const StudyHead& head);

// apps/study/avatar_stability/fold_case.cpp
StabilityCase FoldedLipCase();

// apps/study/avatar_stability/track_cases.cpp
StabilityCase BadFramesCase(const StudyHead& head);
StabilityCase JitterCase(const StudyHead& head);

// apps/study/avatar_stability/component_cases.cpp
StabilityCase EyeballShareCase(const StudyHead& head);

}  // namespace cosplat

// The cases of AvatarStability, one function each, so that tests can run them one at a time.
#pragma once

#include "avatar/study/study_head.h"
#include "splat/study/stability_case.h"

namespace cosplat {

// avatar/study/walk_cases.cpp
StabilityCase ParallelEdgeCase();
StabilityCase BentPathCase();
StabilityCase EndlessWalkCase(const StudyHead& head);

// avatar/study/boundary_case.cpp
StabilityCase BoundaryCase(const StudyHead& head);

// avatar/study/scale_cases.cpp
StabilityCase InverseScaleCase(const StudyHead& head);
StabilityCase UnitsCase(const StudyHead& head);

// avatar/study/expression_cases.cpp
StabilityCase ExpressionSizeCase(const StudyHead& head);
StabilityCase ExpressionReachCase(const StudyHead& head);
StabilityCase HolesCase(const StudyHead& head);

// avatar/study/surface_cases.cpp
StabilityCase OppositeRotationsCase(const StudyHead& head);
StabilityCase CollapsedFacesCase(const StudyHead& head);

// avatar/study/fold_case.cpp
StabilityCase FoldedLipCase();

// avatar/study/track_cases.cpp
StabilityCase BadFramesCase(const StudyHead& head);
StabilityCase JitterCase(const StudyHead& head);

// avatar/study/component_cases.cpp
StabilityCase EyeballShareCase(const StudyHead& head);

}  // namespace cosplat

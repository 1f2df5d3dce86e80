// The cases of AvatarStability, one function each, so that tests can run them one at a time.
#pragma once

#include <vector>

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

// Where avatars bound to a mesh are known to fail: the forms of SplattingAvatar's code release, or
// the plainest ones, beside ours. Nothing here is part of training or of playing.
//
// AvatarStability -> apps/study/stability/stability_case.h -> `cosplat study --stability`;
// tests/study/avatar_stability_test.cpp holds each case to its bound. docs/stability.md explains
// them.

// All cases, measured on the procedural head: the same bits on every run. Some seconds. Writes a
// small video into the system's temporary folder and removes it; throws Error where it cannot.
inline std::vector<StabilityCase> AvatarStability() {
  const StudyHead head;
  return {InverseScaleCase(head),
          UnitsCase(head),
          ExpressionSizeCase(head),
          ExpressionReachCase(head),
          HolesCase(head),
          OppositeRotationsCase(head),
          CollapsedFacesCase(head),
          FoldedLipCase(),
          ParallelEdgeCase(),
          BentPathCase(),
          EndlessWalkCase(head),
          BoundaryCase(head),
          EyeballShareCase(head),
          BadFramesCase(head),
          JitterCase(head)};
}

}  // namespace cosplat

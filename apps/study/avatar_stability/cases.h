// The cases of AvatarStability, one function each, so that tests can run them individually.
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

// Known failure cases of avatars bound to a mesh: the formulas of SplattingAvatar's released code,
// or the most obvious ones, compared with ours. Not used in training or playback.
//
// AvatarStability -> apps/study/stability/stability_case.h -> `cosplat-study --stability`;
// tests/study/avatar_stability_test.cpp checks each case against its bound. docs/stability.md
// explains them.
//
// Returns all cases, measured on the procedural head; bit-identical on every run. Takes some
// seconds. Writes a small video into the system's temporary folder and removes it; throws Error if
// that fails.
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

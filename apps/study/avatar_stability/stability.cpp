#include "apps/study/avatar_stability/stability.h"

#include "apps/study/avatar_stability/cases.h"

namespace cosplat {

std::vector<StabilityCase> AvatarStability() {
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

// Adds the study's rules of pruning to a test program.
#include "apps/study/rules/rules.h"

namespace {

[[maybe_unused]] const bool kRegistered = (cosplat::RegisterStudyRules(), true);

}  // namespace

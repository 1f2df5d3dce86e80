// The glTF extension COSPLAT_mesh_binding, which makes splats an avatar (docs/avatar-file.md).
//
// A child of KHR_gaussian_splatting: it is listed in that extension's `extensions`, on the
// primitive of the splats at rest.
#pragma once

#include <string>

#include "avatar/io/avatar_file.h"
#include "splat/io/glb.h"

namespace cosplat {

inline constexpr const char* kBindingExtension = "COSPLAT_mesh_binding";
// The newest version. An avatar is written in the oldest that has all its fields: 4 with a light
// or corrections, 3 with a bust that follows the head, added teeth or eyelids, 2 with a rule or a
// canonical frame, else 1.
constexpr int kBindingVersion = 4;
inline constexpr const char* kReleasedRule = "splatting-avatar-released";
inline constexpr const char* kRigidRule = "gaussian-avatars";

std::string ToString(ColorFrame frame);  // "surface" or "world"

// Adds the arrays of `model` to `document` and returns the extension's JSON object. splats: the
// primitive of the rest pose, whose colour accessors are shared where they hold the same numbers.
// mesh: index of the canonical mesh in the document, or -1.
Json AddBinding(GlbDocument& document,
                const AvatarModel& model,
                const GlbPrimitive& splats,
                int mesh);

// The extension's object on a primitive with KHR_gaussian_splatting; null (Json) when it has none.
Json FindBinding(const GlbPrimitive& splats);

// Read the avatar, or its summary, from a document that has a binding.
AvatarModel ReadBinding(const GlbDocument& document, const Json& binding);
GlbSummary::Avatar SummarizeBinding(const GlbDocument& document, const Json& binding);

}  // namespace cosplat

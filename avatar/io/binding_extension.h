// COSPLAT_mesh_binding: the avatar's own part of its .glb file (docs/avatar-file.md).
//
// A child of KHR_gaussian_splatting: it stands in that extension's `extensions`, on the primitive
// of the splats at rest.
#pragma once

#include <string>

#include "avatar/io/avatar_file.h"
#include "splat/io/glb.h"

namespace cosplat {

inline constexpr const char* kBindingExtension = "COSPLAT_mesh_binding";
// Of the newest files: those with a rule or a canonical frame. All others are of version 1.
constexpr int kBindingVersion = 2;
inline constexpr const char* kReleasedRule = "splatting-avatar-released";

std::string ToString(ColorFrame frame);  // "surface" or "world"

// Adds the arrays of `model` to `document` and returns the extension's object. splats: the rest
// pose, whose colour accessors are shared where they hold the same numbers. mesh: index of the
// canonical mesh in the document, or -1.
Json AddBinding(GlbDocument& document,
                const AvatarModel& model,
                const GlbPrimitive& splats,
                int mesh);

// The document's only KHR_gaussian_splatting primitive; Error when there is none or more than one.
const GlbPrimitive& FindSplats(const GlbDocument& document);

// The extension's object on that primitive; null (Json) when it has none.
Json FindBinding(const GlbPrimitive& splats);

// The avatar of a document that has a binding.
AvatarModel ReadBinding(const GlbDocument& document, const Json& binding);
GlbSummary::Avatar SummarizeBinding(const GlbDocument& document, const Json& binding);

}  // namespace cosplat

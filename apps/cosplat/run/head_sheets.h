// Pictures of what our own head can do: `cosplat make-head --sheets`.
#pragma once

#include <string>

namespace cosplat {

// Writes into `folder`, made if needed, tiles in rows: expressions.png, each of ARKit's blendshapes
// (kArkitNames, in this order) at 1, mouthClose
// over an open jaw; shapes.png, each direction of shape at -2 and at 2;
// people.png, 24 heads of random shape. Throws Error if a file cannot be written.
void WriteHeadSheets(const std::string& folder);

}  // namespace cosplat

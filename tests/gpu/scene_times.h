// A whole training of a static scene on a device, from a packed file (packed_scene.h), with what
// `cosplat train-scene --eval` does and reports.
#pragma once

#include <string>
#include <vector>

namespace cosplat::test {

//   scene FILE --out FILE.json [--iterations N] [--prune-to N]
// `arguments`: what follows the word. Writes the figures and prints them in a line. Throws Error.
void RunSceneBench(const std::vector<std::string>& arguments);

}  // namespace cosplat::test

// What to say about a command or an option that does not exist.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace cosplat {

// One line about the first argument that no option or command took, with the nearest name that
// exists if one is near: "'--iteratons' is no option of train-scene: did you mean --iterations?".
// Empty if all were taken.
std::string UnknownArgument(const CLI::App& app);

}  // namespace cosplat

// Groups of options: the headings of --help, and which options only --help-all shows.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

namespace cosplat {

// Options that are declared on the command from here on belong to the group. --help leaves out
// groups whose names begin with "More".
void BeginGroup(CLI::App& command, const std::string& name);

// Help of a program and its commands: --help shows options by their names of today, one to a line;
// --help-all shows all groups, and ranges.
std::shared_ptr<CLI::Formatter> MakeHelp();

}  // namespace cosplat

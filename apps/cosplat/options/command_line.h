// What all commands' options have in common: groups, which are the headings of --help and say which
// options only --help-all shows; and config.ini, the options of a run, as `--config` reads them
// again.
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

// All options of a sub-command with their values.
std::string ConfigOf(const CLI::App& app, const CLI::App& command);

// Declares --config on the program. Files of earlier versions are read as these meant them: they
// list options that were left open, with a number that stood for that.
void AddConfig(CLI::App& app);

}  // namespace cosplat

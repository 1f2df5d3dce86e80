// config.ini: the options of a run, as `--config` reads them again.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace cosplat {

// All options of a sub-command with their values.
std::string ConfigOf(const CLI::App& app, const CLI::App& command);

// Declares --config on the program. Files of earlier versions are read as these meant them: they
// list options that were left open, with a number that stood for that.
void AddConfig(CLI::App& app);

}  // namespace cosplat

// What the project's programs have in common: their option parser, messages and exit codes.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace cosplat {

// Parses the command line and runs what `declare` has put on the parser: options of the program,
// and sub-commands. Returns the exit code: 0; 2 for bad input, after one line on standard error;
// or, of a run that was interrupted, 128 and the signal's number.
int RunProgram(const char* name,
               const char* description,
               const std::function<void(CLI::App&)>& declare,
               int argc,
               char** argv);

}  // namespace cosplat

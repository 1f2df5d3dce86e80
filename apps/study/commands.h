// What `cosplat-study` does. Errors are thrown as Error and printed by RunProgram.
#pragma once

#include <CLI/CLI.hpp>

namespace cosplat {

// The program's own options and, unless a sub-command was chosen, the study.
void DeclareStudy(CLI::App& app);
void AddBench(CLI::App& app);
void AddFacePoints(CLI::App& app);
void AddHeadFit(CLI::App& app);
void AddMattes(CLI::App& app);

}  // namespace cosplat

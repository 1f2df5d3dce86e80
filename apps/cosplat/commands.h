// The sub-commands of `cosplat`. Each Add* declares its options on `app` and what runs when it is
// chosen; errors are thrown as Error and printed by main.
#pragma once

#include <CLI/CLI.hpp>

namespace cosplat {

void AddBench(CLI::App& app);
void AddExport(CLI::App& app);
void AddInfo(CLI::App& app);
void AddMakeHead(CLI::App& app);
void AddMetrics(CLI::App& app);
void AddPlay(CLI::App& app);
void AddRender(CLI::App& app);
void AddReport(CLI::App& app);
void AddSend(CLI::App& app);
void AddStudy(CLI::App& app);
void AddTrainAvatar(CLI::App& app);
void AddTrainScene(CLI::App& app);

}  // namespace cosplat

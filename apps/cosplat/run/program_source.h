// `webcam:` and `audio:` as what moves an avatar: this program's own `webcam` and `voice` commands
// beside it.
#pragma once

#include <memory>
#include <string>

#include "avatar/live/source.h"

namespace cosplat {

// "webcam:", "webcam:N", "webcam:FILM"; "audio:" the microphone, "audio:-" standard input.
bool IsProgramDrive(const std::string& drive);

// Starts the command, which ends with the source. Throws Error if it cannot be started; what it has
// to say goes to standard error.
std::unique_ptr<LiveSource> OpenProgram(const std::string& drive, const LiveSourceOptions& options);

// OpenProgram of such a drive, else OpenLiveSource.
std::unique_ptr<LiveSource> OpenLive(const std::string& drive, const LiveSourceOptions& options);

}  // namespace cosplat

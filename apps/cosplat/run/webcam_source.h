// `webcam:` as what moves an avatar: this program's own `webcam` command beside it.
#pragma once

#include <memory>
#include <string>

#include "avatar/live/source.h"

namespace cosplat {

// "webcam:", "webcam:N", "webcam:FILM".
bool IsWebcamDrive(const std::string& drive);

// Starts the command, which ends with the source. Throws Error if it cannot be started; what it has
// to say goes to standard error.
std::unique_ptr<LiveSource> OpenWebcam(const std::string& drive, const LiveSourceOptions& options);

}  // namespace cosplat

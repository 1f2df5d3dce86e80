// Keeps OpenCV and FFmpeg from writing to stderr: failures are reported as Error instead.
#pragma once

namespace cosplat {

// Called before any of their functions; only the first call does anything.
void QuietOpenCv();

}  // namespace cosplat

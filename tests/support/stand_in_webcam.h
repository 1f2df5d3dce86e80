// A `cosplat` in PATH whose webcam sees a jaw that is half open, for hosts that run it.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temporary_folder.h"

namespace cosplat::test {

class StandInWebcam {
 public:
  StandInWebcam() : path_(std::getenv("PATH")) {
    const std::string program = folder_ / "cosplat";
    std::ofstream(program) << R"(#!/bin/sh
[ "$1" = webcam ] || exit 2
i=0
while sleep .02; do i=$((i+1)); echo "{\"seq\": $i, \"blendshapes\": {\"jawOpen\": 0.5}}"; done
)";
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("PATH", (folder_ / "" + ":" + path_).c_str(), 1);
  }
  ~StandInWebcam() { setenv("PATH", path_.c_str(), 1); }
  StandInWebcam(const StandInWebcam&) = delete;
  StandInWebcam& operator=(const StandInWebcam&) = delete;

 private:
  TemporaryFolder folder_;
  std::string path_;
};

}  // namespace cosplat::test

// The programs of apps/landmarks, which find faces by MediaPipe's npm packages in headless
// Chromium.
#pragma once

#include <string>
#include <vector>

namespace cosplat {

struct Mediapipe {
  std::string node, chromium;  // programs
  std::string modules;         // npm's node_modules with the packages
  std::string folder;          // apps/landmarks

  // The arguments of RunProcess that run one of these programs, such as "detect.mjs".
  std::vector<std::string> Command(const std::string& program,
                                   const std::vector<std::string>& options) const;
};

// Throws Error that says what to install if node, npm or Chromium is missing. The first use
// installs the packages by npm into the user's cache folder, and says so on standard error, unless
// quiet.
Mediapipe FindMediapipe(bool quiet);

}  // namespace cosplat

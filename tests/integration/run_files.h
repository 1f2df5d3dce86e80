// The files that a command leaves, to compare byte by byte.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "tests/integration/command.h"

namespace cosplat::test {

// By path within the folder, without the two that have the folder's own name in them. Of stats.json
// only what does not depend on time and memory, of report.html, which has them too, the end.
inline std::map<std::string, std::string> FilesOf(const std::string& folder) {
  namespace fs = std::filesystem;
  std::map<std::string, std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = fs::relative(entry.path(), folder).string();
    if (name == "config.ini" || name == "cfg_args") continue;
    std::string& bytes = files[name] = Slurp(entry.path().string());
    if (name == "report.html")
      bytes = bytes.substr(bytes.size() - std::min<size_t>(8, bytes.size()));
    if (name != "stats.json") continue;
    const Json stats = Json::parse(bytes, nullptr, false);
    bytes = stats.is_discarded() ? "not JSON"
                                 : Json{stats.at("iterations"), stats.at("gaussians")}.dump();
  }
  return files;
}

inline void ExpectSameFiles(const std::map<std::string, std::string>& expected,
                            const std::map<std::string, std::string>& found,
                            const std::string& of) {
  for (const auto& [name, bytes] : expected) {
    const auto file = found.find(name);
    if (file == found.end())
      ADD_FAILURE() << of << ": " << name << " is missing";
    else
      EXPECT_TRUE(file->second == bytes) << of << ": " << name << " differs";
  }
  for (const auto& [name, bytes] : found)
    EXPECT_TRUE(expected.count(name)) << of << ": " << name << " is left over";
}

}  // namespace cosplat::test

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>

#include "apps/cosplat/run/notes.h"
#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "splat/base/error.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

// The arguments of Python's "Namespace(name=value, ...)": strings without their quotes.
std::map<std::string, std::string> ArgumentsIn(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  const std::string text(bytes.begin(), bytes.end());
  std::map<std::string, std::string> arguments;
  size_t at = text.find("Namespace(");
  if (at == std::string::npos) throw Error(path, "is not what 3DGS writes: Namespace(...)");
  at += 10;
  while (at < text.size() && text[at] != ')') {
    const size_t equals = text.find('=', at);
    if (equals == std::string::npos || equals + 1 >= text.size())
      throw Error(path, "ends within its arguments");
    const std::string name = text.substr(at, equals - at);
    const char quote = text[equals + 1];
    std::string value;
    if (quote == '\'' || quote == '"') {
      at = equals + 2;
      for (; at < text.size() && text[at] != quote; ++at) {
        if (text[at] == '\\' && at + 1 < text.size()) ++at;
        value += text[at];
      }
      ++at;
    } else {
      const size_t list = quote == '[' ? text.find(']', equals) : equals;
      const size_t end =
          std::min(text.find_first_of(",)", std::min(list, text.size())), text.size());
      value = text.substr(equals + 1, end - equals - 1);
      at = end;
    }
    arguments[name] = value;
    while (at < text.size() && (text[at] == ',' || text[at] == ' ')) ++at;
  }
  return arguments;
}

int IntegerOr(const std::map<std::string, std::string>& arguments, const char* name, int fallback) {
  const auto found = arguments.find(name);
  if (found == arguments.end()) return fallback;
  int value = fallback;
  std::from_chars(found->second.data(), found->second.data() + found->second.size(), value);
  return value;
}

}  // namespace

Json RunOfCfgArgs(const std::string& folder) {
  const std::string path = folder + "/cfg_args";
  if (std::filesystem::exists(folder + "/avatar.glb"))
    throw Error(folder + "/run.json", "is missing: the run's avatar.glb plays without it");
  const std::map<std::string, std::string> arguments = ArgumentsIn(path);
  const auto text = [&](const char* name, const char* fallback) {
    const auto found = arguments.find(name);
    return found == arguments.end() ? std::string(fallback) : found->second;
  };
  if (text("source_path", "").empty()) throw Error(path, "source_path", "is missing");
  DataSplit split;
  split.eval = text("eval", "False") == "True";
  // -1: full size. What is not 1, 2, 4 or 8 is a width in pixels (camera_utils.py).
  const int resolution = IntegerOr(arguments, "resolution", -1);
  const bool divides = resolution == 1 || resolution == 2 || resolution == 4 || resolution == 8;
  if (!divides && resolution != -1)
    PrintNotes({path + ": resolution " + std::to_string(resolution) +
                " is a width; images are taken at full size (-r N divides them)"});
  split.resolution = divides ? resolution : 1;
  ChooseImages(text("images", "images"), split);
  const float background = text("white_background", "False") == "True" ? 1.0f : 0.0f;
  return {{"kind", "scene"},
          {"source", text("source_path", "")},
          {"split", ToJson(split)},
          {"iterations", std::max(0, LastIteration(folder))},
          {"degree", IntegerOr(arguments, "sh_degree", 3)},
          {"basis", "sh"},
          {"seed", nullptr},
          {"background", {background, background, background}}};
}

}  // namespace cosplat

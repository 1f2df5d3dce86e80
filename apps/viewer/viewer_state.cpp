#include "apps/viewer/viewer_state.h"

#include <cstdlib>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"

namespace cosplat::viewer {
namespace {

constexpr int kMaxWindowSide = 1 << 15;

}  // namespace

std::string ViewerStatePath() {
  const auto folder = [](const char* variable) {
    const char* value = std::getenv(variable);
    return std::string(value != nullptr && *value == '/' ? value : "");
  };
  const std::string state = folder("XDG_STATE_HOME"), home = folder("HOME");
  if (state.empty() && home.empty()) return "";
  return (state.empty() ? home + "/.local/state" : state) + "/cosplat/viewer.json";
}

ViewerState ReadViewerState(const std::string& path) {
  ViewerState state;
  if (path.empty() || !std::filesystem::exists(path)) return state;
  const JsonField json(path, ReadJson(path));
  state.width = json["width"].Integer(0, kMaxWindowSide);
  state.height = json["height"].Integer(0, kMaxWindowSide);
  if (!json["panels"].raw().is_boolean()) json["panels"].Fail("expected true or false");
  state.panels_open = json["panels"].raw().get<bool>();
  state.drive = json["drive"].String();
  return state;
}

void WriteViewerState(const ViewerState& state, const std::string& path) {
  MakeDirectories(std::filesystem::path(path).parent_path().string());
  const Json json{{"width", state.width},
                  {"height", state.height},
                  {"panels", state.panels_open},
                  {"drive", state.drive}};
  WriteFileAtomically(path, json.dump(1) + "\n");
}

}  // namespace cosplat::viewer

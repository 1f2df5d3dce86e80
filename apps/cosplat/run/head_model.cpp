#include "apps/cosplat/run/head_model.h"

#include <filesystem>

#include "assets/head/procedural_head.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOwnHead = "head.npz";

bool IsOwn(const std::string& model) {
  return model.empty() || fs::path(model).filename() == kOwnHead;
}

}  // namespace

std::string HeadModelFor(const std::string& given, const std::string& folder) {
  if (!given.empty()) return given;
  const std::string path = folder + "/" + kOwnHead;
  if (fs::exists(path)) return path;
  MakeDirectories(folder);
  WriteFlameModelNpz(path, MakeHeadForPeople());
  return path;
}

void CheckTrackIsOf(const std::string& given, const std::string& folder) {
  const std::string file = folder + "/track.json";
  if (!fs::exists(file)) {
    // `cosplat track` makes all tracks of our own head, and says so there.
    if (!given.empty() && IsOwn(given)) throw Error(folder, "is no track of " + given);
    return;
  }
  const Json track = ReadJson(file);
  if (!track.contains("flame")) return;  // another program's
  const std::string of = JsonField(file, track)["flame"].String();
  if (IsOwn(of) != IsOwn(given))
    throw Error(folder,
                "is a track of " + of + ", not of " +
                    (given.empty() ? "the program's own head" : given) +
                    ": give the same --flame, or another folder");
}

}  // namespace cosplat

#include "apps/cosplat/run/head_model.h"

#include <filesystem>

#include "assets/head/procedural_head.h"
#include "avatar/io/avatar_file.h"
#include "splat/base/error.h"
#include "splat/base/files.h"

namespace cosplat {

std::string HeadModelFor(const std::string& given, const std::string& folder) {
  if (!given.empty()) return given;
  const std::string path = folder + "/head.npz";
  if (std::filesystem::exists(path)) return path;
  MakeDirectories(folder);
  WriteFlameModelNpz(path, MakeHeadForPeople());
  return path;
}

std::string HeadModelOfTrack(const std::string& given, const std::string& track) {
  if (!given.empty()) return given;
  const std::filesystem::path folder = std::filesystem::weakly_canonical(track);
  for (const auto& place : {folder, folder.parent_path()})
    if (std::filesystem::exists(place / "head.npz")) return (place / "head.npz").string();
  throw Error("--flame",
              "is missing: the model that the track '" + track +
                  "' is of (a track on our own head has head.npz beside it)");
}

FlameModel LoadFlameOfRun(const AvatarModel& avatar,
                          const std::string& path,
                          const JsonField* run,
                          const std::string& given) {
  const bool as_trained = given.empty() && avatar.flame_file.empty() && run;
  return LoadFlameOf(avatar, path, as_trained ? (*run)["flame"].String() : given, "--flame");
}

}  // namespace cosplat

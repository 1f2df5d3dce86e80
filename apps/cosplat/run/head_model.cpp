#include "apps/cosplat/run/head_model.h"

#include <filesystem>
#include <utility>

#include "assets/head/procedural_head.h"
#include "avatar/io/avatar_file.h"
#include "avatar/io/gaussian_avatars.h"
#include "avatar/model/avatar_mesh.h"
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

PosableAvatar LoadPosable(const std::string& glb, const JsonField* run, const std::string& given) {
  AvatarModel model = ReadAvatarGlb(glb);
  const bool as_trained = given.empty() && model.flame_file.empty() && run;
  FlameModel flame =
      LoadFlameOf(model, glb, as_trained ? (*run)["flame"].String() : given, "--flame");
  AttachMesh(model, flame);
  return {std::move(model), std::move(flame)};
}

PosableAvatar LoadGaussianAvatar(const std::string& ply,
                                 const std::string& flame,
                                 const std::string& data) {
  if (flame.empty())
    throw Error(ply, "--flame", "is needed: the FLAME model that it was trained with");
  FlameModel of_file = LoadFlameModel(flame);
  AvatarModel model = ReadGaussianAvatar(ply, of_file, data);
  FlameModel own = FlameOf(model, std::move(of_file));
  return {std::move(model), std::move(own)};
}

}  // namespace cosplat

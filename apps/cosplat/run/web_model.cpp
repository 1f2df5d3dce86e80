#include "apps/cosplat/run/web_model.h"

#include <filesystem>

#include "apps/cosplat/play_content.h"
#include "apps/cosplat/run/run_folder.h"
#include "splat/base/error.h"
#include "splat/io/splat_file.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// The FLAME model that the run beside an avatar names.
std::string FlameOfRun(const std::string& folder) { return ReadRun(folder)["flame"].String(); }

std::string SplatsOfRun(const std::string& folder) {
  return SplatPath(folder, SavedIteration(folder, ReadRun(folder)));
}

}  // namespace

WebModel FindWebModel(const std::string& model, const std::string& flame) {
  const viewer::Content content = LoadContent(model, flame);
  WebModel found;
  found.title = content.title;
  const bool folder = fs::is_directory(model);
  if (!content.avatar) {
    found.splats = folder ? SplatsOfRun(model) : model;
    if (SplatLayoutOf(found.splats) == SplatLayout::kSog &&
        (fs::is_directory(found.splats) || fs::path(found.splats).extension() == ".json"))
      throw Error(found.splats,
                  "is SOG in a folder; the browser's player reads it in one file: `cosplat export "
                  "--splats` with --sog FILE.sog makes it");
    return found;
  }
  found.avatar = folder ? model + "/avatar.glb" : model;
  if (fs::path(found.avatar).extension() != ".glb")
    throw Error(model, "is GaussianAvatars' point cloud: `cosplat export --run` makes a run of it");
  found.flame =
      flame.empty() ? FlameOfRun(fs::absolute(found.avatar).parent_path().string()) : flame;
  found.flame_name = content.avatar->flame.name;
  found.flame_redistributable = content.avatar->flame.redistributable;
  return found;
}

std::string WebFolder(const std::string& file) {
  std::error_code ignored;
  const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = self.parent_path().parent_path() / "share/cosplat/web";
  const fs::path folder = fs::exists(installed / "package.json") ? installed : COSPLAT_WEB_FOLDER;
  if (!fs::exists(folder / file))
    throw Error((folder / file).string(), "is missing: `./run web` builds the browser's player");
  return folder.string();
}

}  // namespace cosplat

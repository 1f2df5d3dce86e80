#include "apps/cosplat/run/web_model.h"

#include <filesystem>
#include <fstream>

#include "apps/cosplat/play_content.h"
#include "apps/cosplat/run/html_page.h"
#include "apps/cosplat/run/run_folder.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/io/splat_file.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// The FLAME model that the run beside an avatar names.
std::string FlameOfRun(const std::string& folder) { return ReadRun(folder)["flame"].String(); }

std::string SplatsOfRun(const std::string& folder) {
  return SplatPath(folder, SavedIteration(folder, ReadRun(folder)));
}

Json FileText(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {{"name", std::filesystem::path(path).filename().string()},
          {"base64", Base64({bytes.begin(), bytes.end()})}};
}

// Whether the player needs a decoder besides its module: of WebP or of Zstandard.
bool NeedsDecoder(const std::string& splats) {
  const SplatLayout layout = SplatLayoutOf(splats);
  if (layout != SplatLayout::kSpz) return layout == SplatLayout::kSog;
  return std::ifstream(splats, std::ios::binary).get() != 0x1f;  // gzip, before version 4
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
  found.flame_name = content.avatar->flame.name;
  if (content.avatar->model.flame_file.empty())
    found.flame =
        flame.empty() ? FlameOfRun(fs::absolute(found.avatar).parent_path().string()) : flame;
  return found;
}

std::string WebFolder(const std::string& file) {
  std::error_code ignored;
  const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path installed = self.parent_path().parent_path() / "share/cosplat/web";
  const fs::path folder = fs::exists(installed / "package.json") ? installed : COSPLAT_WEB_FOLDER;
  if (!fs::exists(folder / file))
    throw Error((folder / file).string(), "is missing: `./run web` builds what pages need");
  return folder.string();
}

void WriteWebPage(const std::string& path, const WebModel& model) {
  if (model.avatar.empty() && NeedsDecoder(model.splats))
    throw Error(model.splats,
                "is SOG or version 4 of SPZ, whose decoders are not in a page of one file: "
                "`cosplat export --splats` makes a PLY or SPZ 3 of it");
  constexpr const char* kTemplate = "dist/offline.html";
  constexpr const char* kPlace = "@MODEL@";
  const std::string file = WebFolder(kTemplate) + "/" + kTemplate;
  const std::vector<char> bytes = ReadFile(file);
  const std::string page(bytes.begin(), bytes.end());
  const size_t at = page.find(kPlace);
  if (at == std::string::npos) throw Error(file, kPlace, "is missing");
  Json content{{"title", model.title}};
  if (model.avatar.empty()) {
    content["splats"] = FileText(model.splats);
  } else {
    content["avatar"] = FileText(model.avatar);
    if (!model.flame.empty()) content["flameName"] = model.flame_name;
  }
  // "<" could end the script that holds it.
  std::string text = content.dump();
  for (size_t k = text.find('<'); k != std::string::npos; k = text.find('<', k))
    text.replace(k, 1, "\\u003c");
  WriteFileAtomically(path,
                      page.substr(0, at) + text + page.substr(at + std::string(kPlace).size()));
}

}  // namespace cosplat

#include "apps/cosplat/run/web_page.h"

#include <filesystem>
#include <fstream>

#include "apps/cosplat/run/data_uri.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/io/splat_file.h"

namespace cosplat {
namespace {

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
    content["flameName"] = model.flame_name;
    if (model.flame_redistributable) content["flame"] = FileText(model.flame);
  }
  // "<" could end the script that holds it.
  std::string text = content.dump();
  for (size_t k = text.find('<'); k != std::string::npos; k = text.find('<', k))
    text.replace(k, 1, "\\u003c");
  WriteFileAtomically(path,
                      page.substr(0, at) + text + page.substr(at + std::string(kPlace).size()));
}

}  // namespace cosplat

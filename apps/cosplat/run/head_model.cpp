#include "apps/cosplat/run/head_model.h"

#include <filesystem>

#include "assets/head/procedural_head.h"
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

}  // namespace cosplat

#include "splat/base/data_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>

#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 8> kImageEndings = {
    ".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".jp2"};

// The place of the image ending in the list; its length if the name has none.
size_t EndingOf(const std::string& name) {
  const std::string ending = LowerCase(fs::path(name).extension().string());
  return size_t(std::find(kImageEndings.begin(), kImageEndings.end(), ending) -
                kImageEndings.begin());
}

// A dot may belong to the name: "frame.0001" has no image ending.
std::string WithoutImageEnding(const std::string& name) {
  return IsImageName(name) ? name.substr(0, name.rfind('.')) : name;
}

}  // namespace

bool IsImageName(const std::string& name) {
  // macOS keeps attributes of 1.jpg in ._1.jpg.
  return EndingOf(name) < kImageEndings.size() &&
         !fs::path(name).filename().string().starts_with("._");
}

std::string ForwardSlashes(const std::string& named) {
  std::string path = named;
  if (path.find('/') == std::string::npos || (path.size() > 1 && path[1] == ':'))
    std::replace(path.begin(), path.end(), '\\', '/');
  if (path.size() > 2 && path[1] == ':' && path[2] == '/' &&
      std::isalpha(static_cast<unsigned char>(path[0])) != 0)
    path.erase(0, 2);
  return path;
}

std::string StemOf(const std::string& named) {
  return WithoutImageEnding(fs::path(ForwardSlashes(named)).filename().string());
}

const DataFiles::Names& DataFiles::NamesIn(const std::string& folder) {
  const auto [found, is_new] = folders_.try_emplace(folder);
  if (!is_new) return found->second;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (IsImageName(name)) found->second[LowerCase(WithoutImageEnding(name))].push_back(name);
  }
  return found->second;
}

// `path` itself, or its folder's image of the same stem: in the same case before another one, then
// by the order of endings.
std::string DataFiles::ImageAt(const std::string& path) {
  if (IsImageName(path) && fs::is_regular_file(path)) return path;
  const std::string folder = fs::path(path).parent_path().string();
  const std::string stem = WithoutImageEnding(fs::path(path).filename().string());
  const Names& names = NamesIn(folder);
  const auto found = names.find(LowerCase(stem));
  if (found == names.end()) return "";
  const auto rank = [&](const std::string& name) {
    return std::make_pair(WithoutImageEnding(name) != stem, EndingOf(name));
  };
  const std::string best = *std::min_element(
      found->second.begin(), found->second.end(), [&](const auto& a, const auto& b) {
        return std::make_pair(rank(a), a) < std::make_pair(rank(b), b);
      });
  return folder.empty() ? best : folder + "/" + best;
}

template <class Exists>
std::string DataFiles::LongestEnd(const std::string& named, const Exists& exists) {
  const fs::path path = fs::path(ForwardSlashes(named)).lexically_normal().relative_path();
  std::vector<std::string> parts;
  for (const fs::path& part : path) parts.push_back(part.string());
  // What leads out of the root ("../images/1.png") is looked for without the way out.
  size_t first = 0;
  while (first < parts.size() && parts[first] == "..") ++first;
  const fs::path direct = fs::path(root_) / fs::path(ForwardSlashes(named)).relative_path();
  if (first > 0) {
    const std::string file = exists(direct.lexically_normal().string());
    if (!file.empty()) return file;
  }
  for (; first < parts.size(); ++first) {
    std::string end = root_;
    for (size_t i = first; i < parts.size(); ++i) end += "/" + parts[i];
    const std::string file = exists(end);
    if (!file.empty()) return file;
  }
  return "";
}

std::string DataFiles::Find(const std::string& named) {
  return LongestEnd(named, [](const std::string& path) {
    return fs::is_regular_file(path) ? path : std::string();
  });
}

std::string DataFiles::FindImage(const std::string& named) {
  return LongestEnd(named, [&](const std::string& path) { return ImageAt(path); });
}

}  // namespace cosplat

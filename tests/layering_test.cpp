// The table of folders in docs/design.md, enforced: who may include whom.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

bool StartsWith(const std::string& text, const std::string& prefix) {
  return text.compare(0, prefix.size(), prefix) == 0;
}
bool StartsWithAny(const std::string& text, const std::vector<std::string>& prefixes) {
  return std::any_of(
      prefixes.begin(), prefixes.end(), [&](const auto& p) { return StartsWith(text, p); });
}
bool IsHeader(const std::string& path) {
  const fs::path extension = fs::path(path).extension();
  return extension == ".h" || extension == ".cuh";
}

// By the beginning of the path, ends in '/' for folders; from cmake/CosplatInstall.cmake.
std::vector<std::string> PrivateHeaders() {
  std::istringstream list(COSPLAT_PRIVATE_HEADERS);
  std::vector<std::string> prefixes;
  for (std::string prefix; std::getline(list, prefix, ',');) prefixes.push_back(prefix);
  return prefixes;
}

using Paths = std::vector<std::string>;
// Those of splat/train/. Each may include itself and those before it.
const Paths kRooms = {"splat/train/loss/",
                      "splat/train/optimize/",
                      "splat/train/blocks/",
                      "splat/train/subject/",
                      "splat/train/start/",
                      "splat/train/state/",
                      "splat/train/ranks/",
                      "splat/train/prune/",
                      "splat/train/density/",
                      "splat/train/step/"};

// What a folder may include of the project: what it does include, and no more. The first that
// matches a file counts.
struct FolderRule {
  std::string folder;
  Paths may_include;
};
const std::vector<FolderRule>& FolderRules() {
  static const std::vector<FolderRule> rules = {
      {"splat/base/", {"splat/base/", "splat/math/"}},
      {"splat/math/", {"splat/math/", "splat/config.h", "splat/basis_constants.h"}},
      {"splat/device/", {"splat/device/", "splat/base/", "splat/math/"}},
      {"splat/render/",
       {"splat/base/",
        "splat/math/",
        "splat/device/",
        "splat/basis",
        "splat/config.h",
        "splat/gaussians.h",
        "splat/render/"}},
      {"splat/levels/",
       {"splat/base/",
        "splat/math/",
        "splat/config.h",
        "splat/gaussians.h",
        "splat/render/",
        "splat/levels/"}},
      {"splat/media/", {"splat/base/", "splat/media/"}},
      {"splat/onnx/", {"splat/base/", "splat/onnx/"}},
      {"splat/io/",
       {"splat/base/",
        "splat/math/",
        "splat/device/",
        "splat/basis",
        "splat/config.h",
        "splat/gaussians.h",
        "splat/io/",
        "splat/media/"}},
      {"splat/train/",
       {"splat/base/",
        "splat/math/",
        "splat/device/",
        "splat/basis",
        "splat/gaussians.h",
        "splat/render/",
        "splat/train/",
        "splat/io/dataset.h"}},
      {"splat/eval/",
       {"splat/base/", "splat/media/", "splat/train/", "splat/eval/", "splat/onnx/"}},
      {"splat/",
       {"splat/base/",
        "splat/math/",
        "splat/device/",
        "splat/basis",
        "splat/config.h",
        "splat/gaussians.h"}},
      {"flame/", {"flame/", "splat/base/", "splat/media/", "splat/math/"}},
      {"avatar/math/", {"avatar/math/", "splat/math/"}},
      {"avatar/model/",
       {"splat/math/",
        "splat/device/",
        "splat/gaussians.h",
        "avatar/math/",
        "avatar/model/",
        "flame/"}},
      {"avatar/surface/",
       {"splat/base/",
        "splat/math/",
        "splat/device/",
        "splat/basis",
        "avatar/math/",
        "avatar/model/",
        "flame/",
        "avatar/surface/",
        "splat/render/"}},
      {"avatar/io/",
       {"splat/base/",
        "avatar/math/",
        "avatar/model/",
        "flame/",
        "avatar/surface/",
        "avatar/io/",
        "splat/io/"}},
      {"avatar/play/",
       {"splat/base/",
        "splat/device/",
        "splat/gaussians.h",
        "avatar/model/",
        "flame/",
        "avatar/surface/",
        "splat/render/",
        "avatar/play/"}},
      {"avatar/train/",
       {"splat/base/",
        "splat/math/",
        "splat/device/",
        "splat/basis",
        "avatar/math/",
        "avatar/model/",
        "flame/",
        "avatar/surface/",
        "splat/render/",
        "avatar/play/",
        "avatar/train/",
        "splat/media/",
        "splat/train/"}},
      {"avatar/live/", {"splat/base/", "avatar/math/", "avatar/model/", "flame/", "avatar/live/"}},
      {"avatar/voice/",
       {"splat/base/", "avatar/math/", "avatar/model/", "avatar/live/", "avatar/voice/"}},
      {"avatar/plugin/",
       {"splat/base/",
        "splat/math/",
        "splat/basis",
        "avatar/model/",
        "flame/",
        "splat/render/",
        "avatar/play/",
        "avatar/live/",
        "avatar/io/",
        "avatar/plugin/"}},
      {"assets/", {"assets/", "flame/", "splat/base/", "splat/media/", "splat/math/"}},
      {"apps/hosts/", {"apps/hosts/"}},  // and <cosplat.h>, as those below
      {"apps/gstreamer/", {"apps/gstreamer/", "apps/hosts/"}},
      {"apps/obs/", {"apps/obs/", "apps/hosts/"}},
      {"apps/viewer/", {"apps/viewer/", "avatar/", "flame/", "splat/"}},
      {"apps/charts/", {"apps/charts/"}},
      {"apps/web/", {"apps/cosplat/", "apps/viewer/", "avatar/plugin/", "avatar/play/", "splat/"}},
      {"apps/cosplat/",
       {"apps/cosplat/", "apps/viewer/", "apps/charts/", "assets/", "avatar/", "flame/", "splat/"}},
      {"apps/study/",
       {"apps/study/", "apps/charts/", "apps/cosplat/", "assets/", "avatar/", "flame/", "splat/"}},
      {"tests/", {"tests/", "apps/", "assets/", "avatar/", "flame/", "splat/"}},
  };
  return rules;
}
// Null for a folder that is not in the table.
const FolderRule* RuleOf(const std::string& path) {
  for (const FolderRule& rule : FolderRules())
    if (StartsWith(path, rule.folder)) return &rule;
  return nullptr;
}

// Libraries that stay where they are. Tests may include any.
struct LibraryRule {
  std::string name;
  std::regex include;
  std::string folder;     // only there, one '*' for any text; empty: anywhere
  bool in_headers;        // whether headers of that folder may include it
  bool in_other_sources;  // whether .cpp files elsewhere may
  bool one_file;          // in one file only
};
const std::vector<LibraryRule>& LibraryRules() {
  static const std::vector<LibraryRule> rules = {
      {"Eigen", std::regex("(unsupported/)?Eigen/.*"), "flame/", true, true, false},
      {"OpenCV", std::regex("opencv2/.*"), "splat/media/", false, false, false},
      {"oneDNN", std::regex("dnnl.*|oneapi/dnnl/.*"), "splat/onnx/", false, false, false},
      {"ONNX", std::regex("onnx/.*|google/protobuf/.*"), "splat/onnx/", false, false, true},
      {"Ceres", std::regex("ceres/.*"), "flame/fit/", true, false, false},
      {"OpenMesh", std::regex("OpenMesh/.*"), "", false, false, true},
      {"tinygltf", std::regex("(.*/)?tiny_gltf\\.h"), "", false, false, true},
      {"oneTBB", std::regex("(tbb|oneapi/tbb)/.*"), "", false, true, false},
      {"Highway", std::regex("hwy/.*"), "", false, true, false},
      {"CUDA", std::regex("cuda_.*|cub/.*|thrust/.*"), "splat/*/cuda/", false, false, false},
      {"MPI", std::regex("mpi\\.h"), "splat/train/ranks/mpi/", false, false, false},
      {"GLFW", std::regex("GLFW/.*"), "apps/viewer/", false, false, false},
      {"Dear ImGui", std::regex("(.*/)?imgui.*"), "apps/viewer/", false, false, false},
  };
  return rules;
}

struct Include {
  std::string target;
  bool quoted;
};

std::vector<Include> IncludesOf(const std::string& text) {
  static const std::regex directive("^[ \\t]*#[ \\t]*include[ \\t]*([<\"])([^>\"]+)[>\"]");
  std::vector<Include> includes;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_search(line, match, directive)) includes.push_back({match[2], match[1] == "\""});
  }
  return includes;
}

std::string CheckFolder(const std::string& path, const Include& include) {
  const bool project = StartsWithAny(
      include.target,
      {"splat/", "flame/", "avatar/", "assets/", "apps/", "tests/", "cosplat/", "../", "./"});
  if (StartsWith(path, "splat/math/") && !project &&
      include.target.find_first_of("/.") != std::string::npos)
    return "formulas include nothing but the standard library";
  if (!project) return include.quoted ? "quotes are for the project's own files" : "";
  // apps/study/ measures what is inside.
  if (StartsWith(path, "apps/") && !StartsWith(path, "apps/study/") &&
      StartsWithAny(include.target, PrivateHeaders()))
    return "a private header";
  const FolderRule* const rule = RuleOf(path);
  if (!rule) return "a folder that is not in the table";
  if (!StartsWithAny(include.target, rule->may_include)) return "not below it in the table";
  for (size_t room = 0; room < kRooms.size(); ++room)
    if (StartsWith(path, kRooms[room]) && StartsWith(include.target, "splat/train/") &&
        !StartsWithAny(include.target, Paths(kRooms.begin(), kRooms.begin() + room + 1)))
      return "not a room before it in the table";
  return "";
}

bool IsIn(const std::string& path, const std::string& folder) {
  const size_t star = folder.find('*');
  if (star == std::string::npos) return StartsWith(path, folder);
  return StartsWith(path, folder.substr(0, star)) &&
         path.find(folder.substr(star + 1), star) != std::string::npos;
}

std::string CheckLibrary(const std::string& path, const Include& include) {
  if (StartsWith(path, "tests/")) return "";
  for (const LibraryRule& rule : LibraryRules()) {
    if (!std::regex_match(include.target, rule.include)) continue;
    if (IsHeader(path)) {
      const bool allowed = rule.in_headers && IsIn(path, rule.folder);
      if (!allowed && !StartsWithAny(path, PrivateHeaders()))
        return rule.name + " in a header that others see";
    }
    if (!IsIn(path, rule.folder) && !rule.in_other_sources)
      return rule.name + " outside " + rule.folder;
  }
  return "";
}

// One line per include that breaks a rule.
std::vector<std::string> Violations(const std::string& path, const std::string& text) {
  std::vector<std::string> found;
  for (const Include& include : IncludesOf(text))
    for (const std::string& problem : {CheckFolder(path, include), CheckLibrary(path, include)})
      if (!problem.empty()) found.push_back(path + " includes " + include.target + ": " + problem);
  return found;
}

struct Source {
  std::string path;  // from the project's root
  std::string text;
};

std::vector<Source> AllSources() {
  const fs::path root = COSPLAT_SOURCE_DIR;
  std::vector<Source> sources;
  for (const char* folder : {"splat", "flame", "avatar", "assets", "apps", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const fs::path extension = entry.path().extension();
      if (!IsHeader(entry.path()) && extension != ".cpp" && extension != ".cu" &&
          extension != ".cuh")
        continue;
      std::ifstream file(entry.path());
      std::ostringstream text;
      text << file.rdbuf();
      sources.push_back({fs::relative(entry.path(), root).generic_string(), text.str()});
    }
  return sources;
}

TEST(Layering, HoldsInEveryFile) {
  const std::vector<Source> sources = AllSources();
  ASSERT_GT(sources.size(), 100u);
  for (const Source& source : sources)
    for (const std::string& violation : Violations(source.path, source.text))
      ADD_FAILURE() << violation;
}

TEST(Layering, AllowsNothingThatIsNotIncluded) {
  std::set<std::string> used;  // folder, permission
  for (const Source& source : AllSources()) {
    const FolderRule* const rule = RuleOf(source.path);
    if (!rule) continue;
    for (const Include& include : IncludesOf(source.text))
      for (const std::string& allowed : rule->may_include)
        if (StartsWith(include.target, allowed)) used.insert(rule->folder + " " + allowed);
  }
  for (const FolderRule& rule : FolderRules())
    for (const std::string& allowed : rule.may_include)
      EXPECT_EQ(used.count(rule.folder + " " + allowed), 1u)
          << rule.folder << " does not include " << allowed;
}

// Paths in backquotes, with one level of {a,b}.
std::set<std::string> PathsNamedIn(const std::string& text) {
  static const std::regex quoted("`([^`{]*)(\\{([^}`]*)\\})?([^`]*)`");
  std::set<std::string> paths;
  for (std::sregex_iterator m(text.begin(), text.end(), quoted), end; m != end; ++m) {
    std::istringstream choices((*m)[3].matched ? (*m)[3].str() : std::string(" "));
    for (std::string choice; std::getline(choices, choice, ',');)
      paths.insert((*m)[1].str() + ((*m)[3].matched ? choice : "") + (*m)[4].str());
  }
  return paths;
}

// docs/design.md, "One core": what is written for CUDA alone. Nothing more may be.
TEST(Layering, WhatIsWrittenForOneBackEndIsInTheTable) {
  std::ifstream file(fs::path(COSPLAT_SOURCE_DIR) / "docs/design.md");
  std::stringstream text;
  text << file.rdbuf();
  const std::string page = text.str();
  const size_t begin = page.find("What is written for one back end");
  ASSERT_NE(begin, std::string::npos);
  const std::set<std::string> listed =
      PathsNamedIn(page.substr(begin, page.find("`tests/layering_test.cpp`", begin) - begin));
  std::set<std::string> there;
  for (const Source& source : AllSources())
    if (source.path.find("/cuda/") != std::string::npos && !StartsWith(source.path, "tests/"))
      there.insert(source.path);
  for (const std::string& path : there) EXPECT_EQ(listed.count(path), 1u) << path;
  for (const std::string& path : listed)
    if (path.find("/cuda/") != std::string::npos) EXPECT_EQ(there.count(path), 1u) << path;
}

// Types that are a device's own: the choice of one, what is known of it, images and textures that
// stay there.
TEST(Layering, FewTypesAreADevices) {
  static const std::regex type("\\b(class|struct) (Device[A-Za-z]*)");
  std::set<std::string> types;
  for (const Source& source : AllSources()) {
    if (StartsWith(source.path, "tests/")) continue;
    for (std::sregex_iterator m(source.text.begin(), source.text.end(), type), end; m != end; ++m)
      types.insert((*m)[2]);
  }
  EXPECT_LE(types.size(), 4u) << testing::PrintToString(types);
}

TEST(Layering, MeshAndGltfLibrariesAreEachInOneFile) {
  for (const LibraryRule& rule : LibraryRules()) {
    if (!rule.one_file) continue;
    std::set<std::string> files;
    for (const Source& source : AllSources()) {
      if (StartsWith(source.path, "tests/")) continue;
      for (const Include& include : IncludesOf(source.text))
        if (std::regex_match(include.target, rule.include)) files.insert(source.path);
    }
    EXPECT_LE(files.size(), 1u) << rule.name << " in " << testing::PrintToString(files);
  }
}

TEST(Layering, PrivateHeadersExist) {
  const std::vector<Source> sources = AllSources();
  for (const std::string& prefix : PrivateHeaders())
    EXPECT_TRUE(std::any_of(sources.begin(), sources.end(), [&](const Source& s) {
      return IsHeader(s.path) && StartsWith(s.path, prefix);
    })) << prefix;
}

TEST(Layering, CheckSeesWhatIsForbidden) {
  const auto breaks = [](const std::string& path, const std::string& include) {
    return !Violations(path, "// a file\n#include " + include + "\n").empty();
  };
  EXPECT_TRUE(breaks("splat/train/loss/loss.cpp", "\"flame/model.h\""));
  EXPECT_TRUE(breaks("splat/train/loss/loss.cpp", "\"avatar/surface/walk.h\""));
  EXPECT_TRUE(breaks("splat/train/loss/loss.cpp", "\"../flame/model.h\""));
  EXPECT_TRUE(breaks("splat/train/loss/loss.cpp", "\"loss.h\""));
  EXPECT_TRUE(breaks("splat/train/loss/loss.cpp", "\"splat/train/step/step_engine.h\""));
  EXPECT_TRUE(breaks("splat/train/step/step_engine.cpp", "\"splat/train/trainer.h\""));
  EXPECT_TRUE(breaks("splat/base/files.cpp", "\"splat/media/image_io.h\""));
  EXPECT_TRUE(breaks("splat/base/files.cpp", "\"splat/gaussians.h\""));
  EXPECT_TRUE(breaks("splat/math/vec.h", "\"splat/gaussians.h\""));
  EXPECT_TRUE(breaks("splat/math/vec.h", "<hwy/highway.h>"));
  EXPECT_TRUE(breaks("splat/math/vec.h", "<Eigen/Core>"));
  EXPECT_TRUE(breaks("flame/pose.cpp", "\"splat/gaussians.h\""));
  EXPECT_TRUE(breaks("avatar/play/player.cpp", "\"apps/cosplat/main.h\""));
  EXPECT_TRUE(breaks("avatar/play/player.cpp", "\"tests/support/dual.h\""));
  EXPECT_TRUE(breaks("apps/cosplat/main.cpp", "\"splat/render/cpu/launch.h\""));
  EXPECT_TRUE(breaks("apps/cosplat/cmd_render.cpp", "\"apps/study/runs/study_list.h\""));
  EXPECT_TRUE(breaks("apps/hosts/avatar_view.cpp", "\"avatar/play/player.h\""));
  EXPECT_TRUE(breaks("apps/gstreamer/cosplat_src.cpp", "\"splat/base/error.h\""));
  EXPECT_TRUE(breaks("apps/viewer/stage.cpp", "\"apps/cosplat/run/run_data.h\""));
  EXPECT_TRUE(breaks("apps/viewer/window.h", "<GLFW/glfw3.h>"));
  EXPECT_TRUE(breaks("apps/viewer/window.cpp", "\"splat/render/cuda/tape.h\""));
  EXPECT_TRUE(breaks("apps/viewer/window.cpp", "<cuda_gl_interop.h>"));
  EXPECT_TRUE(breaks("apps/cosplat/cmd_play.cpp", "<imgui.h>"));
  EXPECT_TRUE(breaks("splat/train/loss/loss.h", "<Eigen/Core>"));
  EXPECT_TRUE(breaks("splat/train/loss/loss.cpp", "<opencv2/core.hpp>"));
  EXPECT_TRUE(breaks("splat/media/image_io.h", "<opencv2/core.hpp>"));
  EXPECT_TRUE(breaks("splat/eval/lpips.cpp", "<dnnl.hpp>"));
  EXPECT_TRUE(breaks("splat/onnx/onnx_net.h", "<dnnl.hpp>"));
  EXPECT_TRUE(breaks("splat/eval/lpips.cpp", "<onnx/onnx_pb.h>"));
  EXPECT_TRUE(breaks("avatar/surface/surface.h", "<OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>"));
  EXPECT_TRUE(breaks("avatar/io/avatar_file.h", "<tiny_gltf.h>"));
  EXPECT_TRUE(breaks("splat/render/rasterizer.h", "<tbb/parallel_for.h>"));
  EXPECT_TRUE(breaks("splat/render/rasterizer.cpp", "\"splat/train/trainer.h\""));
  EXPECT_TRUE(breaks("splat/io/ply.cpp", "\"splat/train/trainer.h\""));
  EXPECT_TRUE(breaks("splat/device/cuda/sort.cu", "\"splat/render/rasterizer.h\""));
  EXPECT_TRUE(breaks("avatar/play/player.cpp", "\"splat/train/trainer.h\""));
  EXPECT_TRUE(breaks("avatar/play/player.cpp", "\"avatar/train/avatar_subject.h\""));
  EXPECT_TRUE(breaks("splat/train/trainer.cpp", "<cuda_runtime.h>"));
  EXPECT_TRUE(breaks("avatar/play/player.cpp", "<cuda_runtime.h>"));
  EXPECT_TRUE(breaks("splat/device/cuda/sort.cu", "\"avatar/surface/surface.h\""));
  EXPECT_TRUE(breaks("splat/device/cuda/sort.cu", "\"tests/support/near.h\""));
  EXPECT_FALSE(breaks("flame/pose.cpp", "<Eigen/Core>"));
  EXPECT_FALSE(breaks("apps/gstreamer/cosplat_src.cpp", "<cosplat.h>"));
  EXPECT_FALSE(breaks("splat/math/vec.h", "<cmath>"));
  EXPECT_FALSE(breaks("splat/device/cuda/stream.h", "<cuda_runtime.h>"));
  EXPECT_FALSE(breaks("avatar/surface/cuda/kernels.cu", "\"splat/device/cuda/kernels.cuh\""));
  EXPECT_FALSE(breaks("tests/avatar/walk_test.cpp", "\"splat/render/cpu/pack.h\""));
}

}  // namespace

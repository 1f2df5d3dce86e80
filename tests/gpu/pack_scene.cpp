// Writes a scene into one file for a machine that can decode no images (packed_scene.h):
//   cosplat_pack_scene FOLDER FILE [--every-test N] [--resolution N]
// Loaded and split as `cosplat train-scene --eval` does; of the test views every N-th.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "tests/gpu/packed_scene.h"

namespace cosplat::test {
namespace {

struct Options {
  std::vector<std::string> paths;
  int every_test = 1, resolution = 1;
};

Options Parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name.rfind("--", 0) != 0) {
      o.paths.push_back(name);
      continue;
    }
    const int value = i + 1 < argc ? std::atoi(argv[++i]) : 0;
    if ((name != "--every-test" && name != "--resolution") || value < 1)
      throw Error("", name, "is not known, or lacks a number of at least 1");
    (name == "--every-test" ? o.every_test : o.resolution) = value;
  }
  if (o.paths.size() != 2) throw Error("", "paths", "FOLDER and FILE are needed");
  return o;
}

void Pack(const Options& o) {
  SceneData data = LoadScene(o.paths[0], {.resolution = o.resolution, .eval = true});
  TrainingScene scene = LoadTrainingScene(data);
  std::vector<TrainFrame> test;
  for (size_t i = 0; i < scene.test.size(); i += size_t(o.every_test))
    test.push_back(std::move(scene.test[i]));
  scene.test = std::move(test);
  WriteFileAtomically(o.paths[1], [&](std::ostream& out) { WritePackedScene(out, scene); });
  std::printf("%s: %zu training and %zu test views, %zu points; %zu views skipped\n",
              o.paths[1].c_str(),
              scene.train.size(),
              scene.test.size(),
              scene.points.size() / 3,
              data.skipped.size());
}

}  // namespace
}  // namespace cosplat::test

int main(int argc, char** argv) {
  try {
    cosplat::test::Pack(cosplat::test::Parse(argc, argv));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cosplat_pack_scene: %s\n", error.what());
    return 2;
  }
}

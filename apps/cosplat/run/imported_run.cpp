#include "apps/cosplat/run/imported_run.h"

#include <cstdlib>
#include <filesystem>

#include "apps/cosplat/run/run_data.h"
#include "apps/cosplat/run/run_folder.h"
#include "avatar/io/avatar_file.h"
#include "flame/track.h"
#include "splat/base/files.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

int IterationOf(const std::string& splats) {
  const std::string folder = fs::absolute(splats).parent_path().filename().string();
  const std::string prefix = "iteration_";
  return folder.starts_with(prefix) ? std::atoi(folder.c_str() + prefix.size()) : 0;
}

}  // namespace

void WriteImportedRun(const std::string& folder,
                      const ImportedFiles& files,
                      const AvatarModel& avatar) {
  const TrackedVideo video = LoadDrivingSequence(files.data);
  const int iteration = IterationOf(files.splats);
  DataSplit split;
  split.eval = true;
  const Json run{{"kind", "avatar"},
                 {"source", fs::absolute(files.data).string()},
                 {"flame", fs::absolute(files.flame).string()},
                 {"imported", fs::absolute(files.splats).string()},
                 {"split", ToJson(split)},
                 {"iterations", iteration},
                 {"degree", avatar.gaussians.degree},
                 {"basis", ToString(avatar.gaussians.basis)},
                 {"seed", nullptr},
                 {"background", avatar.background},
                 {"reference", ReferenceView(video)},
                 {"version", COSPLAT_VERSION}};
  MakeDirectories(folder);
  WriteTrackCameras(folder, video);
  SaveSplats(folder, iteration, RestPose(avatar));
  WriteFileAtomically(folder + "/run.json", run.dump(2) + "\n");
}

}  // namespace cosplat

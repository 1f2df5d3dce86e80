#include "apps/study/runs/study_slurm.h"

#include <filesystem>
#include <sstream>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/process.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

std::string ScriptOf(const std::vector<StudyRun>& runs,
                     const StudySettings& s,
                     const std::string& list) {
  const auto absolute = [](const std::string& path) { return fs::absolute(path).string(); };
  std::vector<std::string> ids;
  for (const StudyRun& run : runs) ids.push_back(run.Id());
  std::vector<std::string> command{fs::read_symlink("/proc/self/exe").string(),
                                   "--list",
                                   absolute(list),
                                   "--data",
                                   absolute(s.data),
                                   "-o",
                                   absolute(s.out)};
  if (!s.lpips.empty()) command.insert(command.end(), {"--lpips", absolute(s.lpips)});
  if (s.keep) command.push_back("--keep");
  // Slurm keeps the script as it was submitted, so the runs are listed in it.
  return "#!/bin/sh\n"
         "#SBATCH --job-name=cosplat-study\n"
         "#SBATCH --array=1-" +
         std::to_string(ids.size()) +
         "\n"
         "set -- " +
         ShellLine(ids) +
         "\n"
         "shift $((SLURM_ARRAY_TASK_ID - 1))\n"
         "exec " +
         ShellLine(command) + " --run \"$1\"\n";
}

}  // namespace

std::string SubmitStudy(const std::vector<StudyRun>& runs,
                        const StudySettings& s,
                        const SlurmJob& job) {
  const std::string sbatch = FindProgram("sbatch");
  if (sbatch.empty())
    throw Error("--slurm", "sbatch is not installed here (Debian: apt-get install slurm-client)");
  const std::string folder = fs::absolute(s.out + "/slurm").string();
  const std::string script = folder + "/study.sbatch";
  MakeDirectories(folder);
  WriteFileAtomically(script, ScriptOf(runs, s, job.list));
  std::vector<std::string> command{sbatch, "--parsable", "--output=" + folder + "/%A_%a.log"};
  std::istringstream options(job.options);
  for (std::string option; options >> option;) command.push_back(option);
  command.push_back(script);
  std::string last;
  const int status = RunProcess(command, {}, [&](const std::string& line) { last = line; });
  if (status != 0) throw Error("sbatch", ExitText(status) + ": " + last);
  return last;
}

}  // namespace cosplat

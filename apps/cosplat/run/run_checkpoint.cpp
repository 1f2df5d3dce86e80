#include "apps/cosplat/run/run_checkpoint.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <sstream>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

// Options that may differ from those of the run that is resumed.
constexpr std::array<const char*, 13> kMayChange{// Where the data is and where results go.
                                                 "source_path",
                                                 "model_path",
                                                 "flame",
                                                 "lpips",
                                                 "landmarks",
                                                 "photographs",
                                                 "video",
                                                 "out",
                                                 // When to save and to evaluate, and what to print.
                                                 "checkpoint-every",
                                                 "save_iterations",
                                                 "test_iterations",
                                                 "quiet",
                                                 "colmap"};

constexpr const char* kStartsAgain = "--overwrite starts again";

std::string CheckpointPath(const std::string& folder) { return folder + "/checkpoint.bin"; }

// The options of a config.ini by name, and its command.
struct Settings {
  std::string command;
  std::map<std::string, std::string> options;
};

Settings SettingsOf(const std::string& config) {
  Settings settings;
  std::istringstream lines(config);
  for (std::string line; std::getline(lines, line);) {
    const size_t dot = line.find('.'), equals = line.find('=');
    if (line.empty() || line[0] == '#' || dot == std::string::npos || equals < dot) continue;
    settings.command = line.substr(0, dot);
    settings.options[line.substr(dot + 1, equals - dot - 1)] = line.substr(equals + 1);
  }
  return settings;
}

// What differs between a run's configuration and the present one, or "".
std::string DifferenceOf(const std::string& of_run, const std::string& present) {
  Settings then = SettingsOf(of_run);
  const Settings now = SettingsOf(present);
  if (then.command != now.command)
    return "by the command " + then.command + ", this is " + now.command;
  // What is left open is not listed.
  for (const auto& [name, value] : now.options) then.options.try_emplace(name, "none");
  for (const auto& [name, value] : then.options) {
    const bool may = std::find(kMayChange.begin(), kMayChange.end(), name) != kMayChange.end();
    const auto other = now.options.find(name);
    const std::string present_value = other == now.options.end() ? "none" : other->second;
    if (value != present_value && !may)
      return "with --" + name + " " + value + " (now " + present_value + ")";
  }
  return "";
}

std::string TextOf(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

struct CheckpointHeader {
  std::string version, config;
  int iteration, iterations;
  DataChecksums data;
};

CheckpointHeader HeaderOf(const StateFile& file) {
  const JsonField field(file.path(), ParseJson(file.path(), file.header()));
  CheckpointHeader header{field["version"].String(),
                          field["config"].String(),
                          field["iteration"].Integer(),
                          field["iterations"].Integer(),
                          {}};
  const JsonField data = field["data"];
  for (size_t i = 0; i < data.size(); ++i)
    header.data.emplace_back(data[i][0].String(), uint32_t(data[i][1].Number()));
  return header;
}

CheckpointHeader HeaderOf(const std::string& folder) {
  try {
    return HeaderOf(StateFile(CheckpointPath(folder)));
  } catch (const Error& error) {
    throw Error(error.what(), kStartsAgain);
  }
}

std::string InterruptedAt(const CheckpointHeader& header) {
  return "an interrupted run, at step " + WithThousands(size_t(header.iteration)) + " of " +
         WithThousands(size_t(header.iterations));
}

bool IsWanted(const std::string& folder, const CheckpointHeader& header) {
  std::fprintf(
      stderr, "%s holds %s. Go on with it? [y/N] ", folder.c_str(), InterruptedAt(header).c_str());
  char answer[16] = "";
  return std::fgets(answer, sizeof answer, stdin) && (answer[0] == 'y' || answer[0] == 'Y');
}

RunStart ChooseToResume(const TrainOptions& o, const std::string& config) {
  const CheckpointHeader header = HeaderOf(o.model);
  std::string difference = DifferenceOf(header.config, config);
  if (header.version != COSPLAT_VERSION)
    difference = "by version " + header.version + ", this is " COSPLAT_VERSION;
  if (!difference.empty())
    throw Error(o.model, "holds an interrupted run, begun " + difference + ": " + kStartsAgain);
  if (o.resume) return RunStart::kResumed;
  const bool asks = isatty(STDIN_FILENO) && isatty(STDERR_FILENO);
  if (asks && IsWanted(o.model, header)) return RunStart::kResumed;
  throw Error(
      o.model,
      "holds " + InterruptedAt(header) + ": --resume goes on, " + std::string(kStartsAgain));
}

bool IsFinished(const std::string& folder) {
  return fs::exists(folder + "/stats.json") && !fs::exists(CheckpointPath(folder));
}

}  // namespace

RunStart ChooseStart(const TrainOptions& o, const std::string& config) {
  if (o.overwrite) return RunStart::kNew;
  if (fs::exists(CheckpointPath(o.model))) return ChooseToResume(o, config);
  if (!IsFinished(o.model)) return RunStart::kNew;
  if (!o.resume) throw Error(o.model, "holds a finished run: --overwrite replaces it");
  const std::string difference = DifferenceOf(TextOf(o.model + "/config.ini"), config);
  if (!difference.empty())
    throw Error(o.model, "holds a finished run, begun " + difference + ": --overwrite replaces it");
  // Interrupted in its evaluation, without a checkpoint.
  const bool evaluated = fs::exists(o.model + "/results.json");
  return (o.eval || o.fold) && !evaluated ? RunStart::kNew : RunStart::kFinished;
}

RunStart ChooseStart(const TrainOptions& o, const std::string& config, Ranks& ranks) {
  RunStart start = RunStart::kNew;
  std::string problem;
  if (ranks.rank() == 0) problem = Problem([&] { start = ChooseStart(o, config); });
  problem = TextOfRankZero(problem, ranks);
  if (!problem.empty()) throw Error(problem, "");
  return RunStart(Largest(uint32_t(start), ranks));
}

void RequireNoRun(const std::string& folder) {
  if (fs::exists(CheckpointPath(folder)))
    throw Error(folder, "holds " + InterruptedAt(HeaderOf(folder)) + ": " + kStartsAgain);
  if (IsFinished(folder)) throw Error(folder, "holds a finished run: --overwrite replaces it");
}

RunCheckpoint::RunCheckpoint(const TrainOptions& o,
                             std::string config,
                             RunStart start,
                             DataChecksums data)
    : folder_(o.model),
      path_(CheckpointPath(o.model)),
      config_(std::move(config)),
      iterations_(o.iterations),
      interval_(60.0 * double(o.checkpoint_every)),
      start_(start),
      data_(std::move(data)),
      last_(std::chrono::steady_clock::now()) {}

int RunCheckpoint::Read(const StateDescription& describe) const {
  const StateFile file(path_);
  const CheckpointHeader header = HeaderOf(file);
  const DataChecksums& then = header.data;
  for (size_t i = 0; i < std::max(then.size(), data_.size()); ++i) {
    if (i < then.size() && i < data_.size() && then[i] == data_[i]) continue;
    const std::string name = i < data_.size() ? data_[i].first : then[i].first;
    throw Error(folder_,
                "holds an interrupted run on other data, first " + name + ": " + kStartsAgain);
  }
  file.Read(describe);
  return header.iteration;
}

// What the description exchanges with the other ranks takes place even if the first of them cannot
// write.
void RunCheckpoint::WriteTogether(const std::string& path,
                                  const std::string& header,
                                  const StateDescription& describe,
                                  const Ranks& ranks) {
  last_ = std::chrono::steady_clock::now();  // also after a failure: not again at every step
  lost_ = true;                              // until the description has come to its end
  bool begun = false;
  const auto visit = [&](StateArchive& archive) {
    begun = true;
    describe(archive);
    lost_ = false;
  };
  try {
    ranks.rank() == 0 ? WriteStateFile(path, header, visit) : DiscardState(visit);
  } catch (const Error&) {
    if (!begun) DiscardState(visit);
    throw;
  }
  last_ = std::chrono::steady_clock::now();
}

bool RunCheckpoint::IsDue() const {
  return interval_.count() > 0 && std::chrono::steady_clock::now() - last_ >= interval_;
}

void RunCheckpoint::Write(int iteration, const StateDescription& describe, const Ranks& ranks) {
  Json data = Json::array();
  for (const auto& [name, checksum] : data_) data.push_back({name, checksum});
  const Json header{{"version", COSPLAT_VERSION},
                    {"config", config_},
                    {"iteration", iteration},
                    {"iterations", iterations_},
                    {"data", data}};
  WriteTogether(path_, header.dump(), describe, ranks);
}

void RunCheckpoint::WritePart(const std::string& path,
                              const StateDescription& describe,
                              const Ranks& ranks) {
  WriteTogether(path, "", describe, ranks);
}

void RunCheckpoint::Try(const std::function<void()>& write) const {
  if (interval_.count() == 0) return;
  try {
    write();
  } catch (const Error& error) {
    if (lost_) throw;
    std::fprintf(stderr, "cosplat: warning: no checkpoint: %s\n", error.what());
  }
}

void RunCheckpoint::Remove() const { RemoveFile(path_); }

Agreement AgreeAfterStep(int signal, const RunCheckpoint& checkpoint, Ranks& ranks) {
  constexpr uint32_t kDue = 256;  // above any signal
  const uint32_t own = uint32_t(signal) + (ranks.rank() == 0 && checkpoint.IsDue() ? kDue : 0);
  const uint32_t agreed = Largest(own, ranks);
  return {int(agreed % kDue), agreed >= kDue};
}

}  // namespace cosplat

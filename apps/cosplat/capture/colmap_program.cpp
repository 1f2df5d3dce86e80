#include "apps/cosplat/capture/colmap_program.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>

#include "apps/cosplat/run/progress_bar.h"
#include "splat/base/error.h"
#include "splat/base/process.h"

namespace cosplat {
namespace {

constexpr size_t kTail = 5;             // lines shown of a command that failed
constexpr size_t kMaxHelpLines = 5000;  // `yes help` would print for ever
constexpr int kSignal = 128;            // RunProcess: more says which signal killed the program

// COLMAP is a Qt program, which would need a display.
const std::vector<std::string> kEnvironment{"QT_QPA_PLATFORM=offscreen"};

// The answer to a question about the program, line by line. Versions end it with any exit status.
void Ask(const std::vector<std::string>& args,
         const std::function<void(const std::string& line)>& on_line) {
  size_t lines = 0;
  const int status = RunProcess(args, kEnvironment, [&](const std::string& line) {
    if (++lines > kMaxHelpLines) throw Error("--colmap " + args[0], "is not COLMAP");
    on_line(line);
  });
  if (status >= kSignal)
    throw Error("--colmap " + args[0], "`" + args[1] + "` of it " + ExitText(status));
}

struct Progress {
  int done = 0, total = 0;  // total 0: one per photograph
};

// From a line of COLMAP's output, such as "Processed file [3/50]", "Matching block [1/5, 2/5] in
// 0.4s", "Registering image #12 (5)" or, since 3.12, "(num_reg_frames=5)"; newer versions put the
// time and the place in the source before it. Done is 0 where the line says nothing about progress.
Progress ParseProgress(const std::string& line) {
  int a = 0, n = 0, b = 0, m = 0;
  const size_t bracket = line.find('['), image = line.find("Registering image #");
  if (bracket != std::string::npos) {
    const char* text = line.c_str() + bracket;
    if (std::sscanf(text, "[%d/%d, %d/%d]", &a, &n, &b, &m) == 4) return {(a - 1) * m + b, n * m};
    if (std::sscanf(text, "[%d/%d]", &a, &n) == 2) return {a, n};
  }
  if (image == std::string::npos) return {};
  const char* text = line.c_str() + image;
  if (std::sscanf(text, "Registering image #%d (%d)", &n, &a) == 2 ||
      std::sscanf(text, "Registering image #%d (%*[a-z_]=%d)", &n, &a) == 2)
    return {a, 0};
  return {};
}

}  // namespace

ColmapProgram::ColmapProgram(std::string path) : path_(std::move(path)) {
  Ask({path_, "help"}, [&](const std::string& line) {
    std::istringstream words(line);
    std::string command, more;
    if (words >> command && !(words >> more)) commands_.insert(command);
  });
  for (const char* command : {"feature_extractor", "mapper", "image_undistorter"})
    if (!Has(command))
      throw Error("--colmap " + path_,
                  std::string("is not COLMAP: its `help` lists no command ") + command);
}

const std::set<std::string>& ColmapProgram::OptionsOf(const std::string& command) {
  const auto [entry, is_new] = options_.try_emplace(command);
  std::set<std::string>& options = entry->second;
  if (!is_new) return options;
  Ask({path_, command, "-h"}, [&](const std::string& line) {
    std::istringstream words(line);
    std::string word;
    if (words >> word && word.starts_with("--")) options.insert(word);
  });
  return options;
}

bool ColmapProgram::Takes(const std::string& command, const std::string& option) {
  return OptionsOf(command).contains(option);
}

std::vector<std::string> ColmapProgram::Arguments(const std::string& command,
                                                  const ColmapOptions& options) {
  std::vector<std::string> args{path_, command};
  for (const ColmapOption& option : options) {
    const auto name =
        std::find_if(option.names.begin(), option.names.end(), [&](const std::string& candidate) {
          return Takes(command, candidate);
        });
    if (name != option.names.end()) {
      args.insert(args.end(), {*name, option.value});
    } else if (option.required) {
      throw Error("colmap " + command,
                  option.names.front(),
                  "is not among the options that `" + path_ + " " + command + " -h` lists");
    }
  }
  return args;
}

int ColmapRunner::TryRun(const std::string& title,
                         const std::string& command,
                         const ColmapOptions& options) {
  ColmapOptions all = options;
  all.push_back({{"--log_target"}, "stderr", false});  // 4.2 writes files to /tmp, too, else
  const std::vector<std::string> args = program_.Arguments(command, all);
  std::ofstream log(log_, std::ios::app);
  log << "$";
  for (const std::string& arg : args) log << " " << arg;
  log << std::endl;
  if (!log) throw Error(log_, "cannot be written");
  tail_.clear();
  std::unique_ptr<ProgressBar> bar;
  return RunProcess(args, kEnvironment, [&](const std::string& line) {
    log << line << std::endl;
    Remember(line);
    const Progress progress = ParseProgress(line);
    if (progress.done < 1) return;
    const int total = progress.total > 0 ? progress.total : photographs_;
    if (!bar) bar = std::make_unique<ProgressBar>(title, total, quiet_, OffTerminal::kLines);
    bar->Update(std::min(progress.done, total), "");
  });
}

void ColmapRunner::Run(const std::string& title,
                       const std::string& command,
                       const ColmapOptions& options) {
  const int status = TryRun(title, command, options);
  if (status != 0) Fail(command, status);
}

void ColmapRunner::Fail(const std::string& command, int status) const {
  for (const std::string& line : tail_) std::fprintf(stderr, "  %s\n", line.c_str());
  throw Error("colmap " + command, ExitText(status) + "; its log is " + log_);
}

void ColmapRunner::Remember(const std::string& line) {
  const size_t first = line.find_first_not_of(" =");
  if (first == std::string::npos) return;           // empty, or a rule
  if (line.compare(first, 4, "@   ") == 0) return;  // of a stack trace
  tail_.push_back(line);
  if (tail_.size() > kTail) tail_.pop_front();
}

}  // namespace cosplat

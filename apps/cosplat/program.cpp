#include "apps/cosplat/program.h"

#include <tbb/global_control.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <numeric>
#include <string>
#include <vector>

#include "apps/cosplat/options/command_line.h"
#include "apps/cosplat/run/stop_signals.h"

namespace cosplat {
namespace {

constexpr int kBadInput = 2;

// Letters to insert, remove or replace (Levenshtein 1966).
size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, replaced});
    }
  }
  return row.back();
}

// The nearest of the names, or "" if more than a third of the letters differ.
std::string Nearest(const std::string& word, const std::vector<std::string>& names) {
  std::string nearest;
  size_t min = std::max(size_t(2), word.size() / 3) + 1;
  for (const std::string& name : names) {
    const size_t distance = EditDistance(word, name);
    if (distance < min) {
      min = distance;
      nearest = name;
    }
  }
  return nearest;
}

std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// One line about the first argument that no option or command took, with the nearest name that
// exists if one is near: "'--iteratons' is no option of train-scene: did you mean --iterations?".
// Empty if all were taken.
std::string UnknownArgument(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty()) return "";
  const std::string word = unknown[0].substr(0, unknown[0].find('='));
  const std::vector<CLI::App*> commands = app.get_subcommands();
  std::vector<std::string> names;
  std::string text = "'" + word + "' is no ";
  if (word.starts_with("-")) {
    names = OptionNames(app);
    for (const CLI::App* command : commands)
      for (const std::string& name : OptionNames(*command)) names.push_back(name);
    text += commands.empty() ? "option" : "option of " + commands[0]->get_name();
  } else if (commands.empty()) {
    if (word == "study" || word == "bench")
      return "'" + word + "' is of the program cosplat-study (docs/study.md)";
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    text += "command";
  } else {
    return "'" + word + "' belongs to no option of " + commands[0]->get_name();
  }
  const std::string nearest = Nearest(word, names);
  return nearest.empty() ? text : text + ": did you mean " + nearest + "?";
}

// `name`: of the program, as it begins its messages.
std::string FailureMessage(const std::string& name, const CLI::App& failed, const CLI::Error& e) {
  const std::string end = " (--help lists the options)\n";
  if (dynamic_cast<const CLI::ConfigError*>(&e) != nullptr)
    return name + ": " + failed.get_config_ptr()->as<std::string>() + ": " + e.what() + end;
  // A misspelled name leaves what it stands for missing, which says less.
  const std::string unknown = UnknownArgument(failed);
  return name + ": " + (unknown.empty() ? e.what() : unknown) + end;
}

int Parse(const char* name,
          const char* description,
          const std::function<void(CLI::App&)>& declare,
          int argc,
          char** argv) {
  CLI::App app(description, name);
  app.formatter(MakeHelp());
  app.set_help_all_flag("--help-all", "print all options, with their ranges, and exit");
  app.option_defaults()->always_capture_default();  // so that config.ini is complete
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.failure_message([name](const CLI::App* failed, const CLI::Error& e) {
    return FailureMessage(name, *failed, e);
  });
  app.fallthrough();
  AddConfig(app);
  app.set_version_flag("--version", COSPLAT_VERSION);
  int threads = 0;
  app.add_option("--threads", threads, "threads to use; 0: one per core")
      ->check(CLI::Range(0, 1024));
  std::unique_ptr<tbb::global_control> limit;
  app.parse_complete_callback([&] {
    if (threads > 0)
      limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    threads);
  });
  declare(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& e) {  // of a command that ran
    return e.get_exit_code();
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);
    return code == 0 ? 0 : kBadInput;
  }
  return 0;
}

// Images come and go by the hundred, and glibc gives what is freed back to the system, which clears
// each page again when it is fetched. Kept are blocks of up to 32 MiB, its limit.
void KeepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

}  // namespace

int RunProgram(const char* name,
               const char* description,
               const std::function<void(CLI::App&)>& declare,
               int argc,
               char** argv) {
  KeepFreedMemory();
  try {
    return Parse(name, description, declare, argc, argv);
  } catch (const Stopped& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    return 128 + e.signal;  // as a shell says that it was killed by the signal
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: out of memory\n", name);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
  }
  return kBadInput;
}

}  // namespace cosplat

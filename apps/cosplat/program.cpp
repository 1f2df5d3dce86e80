#include "apps/cosplat/program.h"

#include <tbb/global_control.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "apps/cosplat/options/config_file.h"
#include "apps/cosplat/options/option_groups.h"
#include "apps/cosplat/run/stop_signals.h"
#include "apps/cosplat/spelling.h"

namespace cosplat {
namespace {

constexpr int kBadInput = 2;

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

}  // namespace

int RunProgram(const char* name,
               const char* description,
               const std::function<void(CLI::App&)>& declare,
               int argc,
               char** argv) {
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

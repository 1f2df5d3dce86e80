#include "apps/study/runs/study_child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <ctime>
#include <filesystem>

#include "apps/study/runs/study_list.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

// This program for a training, by any rule, otherwise `cosplat`, which lies beside it.
std::filesystem::path ProgramOf(const std::string& command) {
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe");
  return command.starts_with("train-") ? self : self.parent_path() / "cosplat";
}

// Starts the child with the signal mask that the parent had before blocking signals.
pid_t Spawn(const std::vector<std::string>& arguments, const sigset_t& signals) {
  std::vector<char*> argv{const_cast<char*>("cosplat")};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setsigmask(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const std::string program = ProgramOf(arguments[0]);
  const int problem =
      posix_spawn(&child, program.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (problem != 0)
    throw Error(program, std::string("cannot be started: ") + std::strerror(problem));
  return child;
}

bool IsStop(int signal) { return signal == SIGINT || signal == SIGTERM; }

}  // namespace

StudyChildren::StudyChildren() {
  sigemptyset(&waited_for_);
  for (const int signal : {SIGINT, SIGTERM, SIGCHLD}) sigaddset(&waited_for_, signal);
  pthread_sigmask(SIG_BLOCK, &waited_for_, &before_);
}

StudyChildren::~StudyChildren() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

void StudyChildren::Run(const std::vector<std::string>& arguments) const {
  const pid_t child = Spawn(arguments, before_);
  bool stopped = false;
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(child, &status, stopped ? 0 : WNOHANG)) == 0) {
    stopped = IsStop(sigwaitinfo(&waited_for_, nullptr));
    if (stopped) kill(child, SIGTERM);
  }
  // Ctrl-C in a terminal also reaches the child, which may exit before the parent sees the signal.
  const timespec at_once{};
  for (int signal; (signal = sigtimedwait(&waited_for_, nullptr, &at_once)) > 0;)
    stopped = stopped || IsStop(signal);
  if (ended < 0) throw Error("study", "a run's process", "was lost");
  if (stopped) throw StudyStopped("study: stopped; the same command goes on from here");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  const std::string how = WIFSIGNALED(status)
                              ? "was killed by signal " + std::to_string(WTERMSIG(status))
                              : "failed with code " + std::to_string(WEXITSTATUS(status));
  throw Error(ProgramOf(arguments[0]).filename().string() + " " + ShellLine(arguments), how);
}

}  // namespace cosplat

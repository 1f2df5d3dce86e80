// `cosplat` in the background, to be interrupted.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/integration/command.h"

namespace cosplat::test {

inline double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class BackgroundCommand {
 public:
  // What it prints goes to the file `log`. `environment`: "NAME=VALUE", set besides that of this
  // process. `program`: another one, by its path.
  BackgroundCommand(const std::vector<std::string>& arguments,
                    const std::string& log,
                    const std::vector<std::string>& environment = {},
                    const char* program = COSPLAT_COMMAND) {
    std::vector<char*> argv{const_cast<char*>(program)};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
    for (const std::string& e : environment) putenv(const_cast<char*>(e.c_str()));
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~BackgroundCommand() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  BackgroundCommand(const BackgroundCommand&) = delete;
  BackgroundCommand& operator=(const BackgroundCommand&) = delete;

  // Whether it has ended within the time.
  bool EndsWithin(double seconds) {
    for (const double end = Seconds() + seconds; pid_ > 0; usleep(300)) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      } else if (Seconds() >= end) {
        return false;
      }
    }
    return true;
  }
  void Signal(int signal) { kill(pid_, signal); }
  pid_t pid() const { return pid_; }
  // Once it has ended; 128 + signal where it was killed.
  int status() const { return status_; }

 private:
  pid_t pid_ = -1;
  int status_ = -1;
};

}  // namespace cosplat::test

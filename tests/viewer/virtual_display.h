// An X server without a screen (Xvfb), for as long as this is there; Mesa draws on the processor.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>

namespace cosplat::test {

class VirtualDisplay {
 public:
  VirtualDisplay() {
    int ends[2];
    if (pipe(ends) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      close(ends[0]);
      // It tries displays in turn and complains about those that are taken.
      dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
      const std::string number = std::to_string(ends[1]);
      execlp("Xvfb",
             "Xvfb",
             "-displayfd",
             number.c_str(),
             "-screen",
             "0",
             "1600x1000x24",
             "-nolisten",
             "tcp",
             "-noreset",  // when the last window closes: the next could not open meanwhile
             nullptr);
      _exit(127);
    }
    close(ends[1]);
    std::string name;  // Xvfb picks a display that is free and says which, with a newline
    for (char c; read(ends[0], &c, 1) == 1 && c != '\n';) name += c;
    close(ends[0]);
    if (name.empty()) return;
    there_is_ = true;
    setenv("DISPLAY", (":" + name).c_str(), 1);
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  }
  ~VirtualDisplay() {
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  // False where Xvfb is not installed or does not start.
  bool there_is() const { return there_is_; }

 private:
  pid_t process_ = -1;
  bool there_is_ = false;
};

}  // namespace cosplat::test

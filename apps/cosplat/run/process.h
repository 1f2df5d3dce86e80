// Other programs that a command uses (COLMAP, node), run as child processes without a shell.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cosplat {

// The file of a program: `name` itself if it contains a slash, else the first match in PATH. Empty
// if there is no such executable file.
std::string FindProgram(const std::string& name);

// A program that runs beside this one. It does not outlive this process: it gets
// Ctrl-C as well, and SIGTERM if this process, or the thread that started it, ends.
class ChildProcess {
 public:
  // Where the child's standard error goes: into the pipe of its output, or where this process's
  // does.
  enum class Errors { kWithOutput, kAsOurs };
  // What it reads: nothing, or this process's standard input.
  enum class Input { kNothing, kOurs };
  // Starts argv[0], a path, with these arguments. `environment` has NAME=VALUE, set besides what
  // this process has. Throws Error if it cannot be started.
  ChildProcess(const std::vector<std::string>& argv,
               const std::vector<std::string>& environment,
               Errors errors,
               Input input = Input::kNothing);
  // Ends the child by SIGTERM, and waits for it.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  int output() const;  // the descriptor that its standard output is read from
  bool HasEnded();     // then `status` says how
  int Wait();          // until it has ended; its status
  int status() const;  // the exit status, or 128 + the signal that killed it

 private:
  struct Running;
  std::unique_ptr<Running> running_;
};

// Runs argv[0], a path, with these arguments until it ends. `on_line` gets each line that it writes
// to standard output or standard error, without its end ('\n' or '\r') and a terminal's colours.
// Returns ChildProcess::status. What `on_line` throws is passed on after the child has ended.
// Throws Error if the program cannot be started.
int RunProcess(const std::vector<std::string>& argv,
               const std::vector<std::string>& environment,
               const std::function<void(const std::string& line)>& on_line);

// "exited with status 1", "was killed by signal 9 (Killed)": what RunProcess returned.
std::string ExitText(int status);

}  // namespace cosplat

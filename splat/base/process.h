// Other programs that this one uses (COLMAP, node, `cosplat webcam`), run as child processes
// without a shell.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cosplat {

// The file of a program: `name` itself if it contains a slash, else the first match in PATH. Empty
// if there is no such executable file.
std::string FindProgram(const std::string& name);

// The file of the program that this is.
std::string ThisProgram();

// Thrown where the page that a module runs in has to do something first (process_web.cpp).
struct PageIsAsked {};

// A program that runs beside this one. It does not outlive this process: it gets
// Ctrl-C as well, and SIGTERM if this process ends.
class ChildProcess {
 public:
  // Where the child's standard error goes: into the pipe of its output, into one of its own, or
  // where this process's does.
  enum class Errors { kWithOutput, kApart, kAsOurs };
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

  int output() const;     // the descriptor that its standard output is read from
  int errors() const;     // of kApart: its standard error
  bool HasEnded() const;  // then Wait returns at once
  int Wait();             // until it has ended; its exit status, or 128 + the signal that killed it

 private:
  struct Running;
  std::unique_ptr<Running> running_;
};

// What a child writes, by the line, without its end ('\n' or '\r') and a terminal's colours.
class OutputLines {
 public:
  OutputLines(int descriptor, std::function<void(const std::string& line)> use);
  // Waits for output, and reads until there is none for now. Returns whether more may come.
  bool ReadAvailable(int milliseconds);
  // What is left, without an end.
  void Finish();

 private:
  void Add(char c);

  int descriptor_;
  std::function<void(const std::string& line)> use_;
  std::string line_;  // read so far
};

// Runs argv[0], a path, with these arguments until it ends. `on_line` gets each line that it writes
// to standard output or standard error. Returns ChildProcess::Wait's status. What `on_line` throws
// is passed on after the child has ended. Throws Error if the program cannot be started.
int RunProcess(const std::vector<std::string>& argv,
               const std::vector<std::string>& environment,
               const std::function<void(const std::string& line)>& on_line);

// "exited with status 1", "was killed by signal 9 (Killed)": what RunProcess returned.
std::string ExitText(int status);

}  // namespace cosplat

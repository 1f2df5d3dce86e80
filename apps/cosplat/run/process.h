// Other programs that a command uses (COLMAP, node), run as child processes without a shell.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace cosplat {

// The file of a program: `name` itself if it contains a slash, else the first match in PATH. Empty
// if there is no such executable file.
std::string FindProgram(const std::string& name);

// Runs argv[0], a path, with these arguments until it ends. `environment` has NAME=VALUE, set
// besides what this process has. The child reads nothing; `on_line` gets each line that it writes
// to standard output or standard error, without its end ('\n' or '\r') and a terminal's colours.
//
// Returns the exit status, or 128 + the signal that killed it. The child does not outlive this
// process: it gets Ctrl-C as well, and SIGTERM if this process dies or `on_line` throws (which is
// passed on after the child has ended). Throws Error if the program cannot be started. Call it from
// the main thread: the end of the thread that calls counts as this process's.
int RunProcess(const std::vector<std::string>& argv,
               const std::vector<std::string>& environment,
               const std::function<void(const std::string& line)>& on_line);

// "exited with status 1", "was killed by signal 9 (Killed)": what RunProcess returned.
std::string ExitText(int status);

}  // namespace cosplat

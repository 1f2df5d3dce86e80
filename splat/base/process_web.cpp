// A page has no other programs, but it may play the part of one: RunProcess calls `program` of the
// module's object with the arguments. That answers with an exit status, or with -1 if it has to be
// asked again once it has worked (PageIsAsked); answers from then on are kept by the page, which
// counts the calls.
#include <emscripten.h>

#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/process.h"

EM_JS(int, cosplat_page_program, (const char* json), {
  return Module["program"] ? Module["program"](JSON.parse(UTF8ToString(json))) : 127;
})

namespace cosplat {

std::string FindProgram(const std::string&) { return ""; }
std::string ThisProgram() { return ""; }

struct ChildProcess::Running {};
ChildProcess::ChildProcess(const std::vector<std::string>& argv,
                           const std::vector<std::string>&,
                           Errors,
                           Input) {
  throw Error(argv[0], "cannot be started by a page");
}
ChildProcess::~ChildProcess() = default;
int ChildProcess::output() const { return -1; }
int ChildProcess::errors() const { return -1; }
bool ChildProcess::HasEnded() const { return true; }
int ChildProcess::Wait() { return 0; }

OutputLines::OutputLines(int descriptor, std::function<void(const std::string& line)> use)
    : descriptor_(descriptor), use_(std::move(use)) {}
bool OutputLines::ReadAvailable(int) { return false; }
void OutputLines::Finish() {}

int RunProcess(const std::vector<std::string>& argv,
               const std::vector<std::string>&,
               const std::function<void(const std::string& line)>&) {
  const int status = cosplat_page_program(Json(argv).dump().c_str());
  if (status < 0) throw PageIsAsked();
  return status;
}

std::string ExitText(int status) { return "exited with status " + std::to_string(status); }

}  // namespace cosplat

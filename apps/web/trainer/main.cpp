// cosplat-trainer: `cosplat avatar` in a page, of images in the module's file system.
#include "apps/cosplat/commands.h"
#include "apps/cosplat/program.h"
#include "splat/base/page_is_asked.h"

// 75 (sysexits' EX_TEMPFAIL): the page has something to do first, and calls again.
int main(int argc, char** argv) {
  constexpr int kPageIsAsked = 75;
  try {
    return cosplat::RunProgram(
        "cosplat-trainer",
        "Head avatars, in a page.",
        [](CLI::App& app) {
          app.require_subcommand(1);
          cosplat::AddAvatar(app);
          cosplat::AddTrainAvatar(app);
        },
        argc,
        argv);
  } catch (const cosplat::PageIsAsked&) {
    return kPageIsAsked;
  }
}

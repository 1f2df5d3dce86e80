// cosplat: head avatars from tracked video, static scenes from images.
#include "apps/cosplat/commands.h"
#include "apps/cosplat/program.h"

namespace cosplat {
namespace {

void AddCommands(CLI::App& app) {
  app.require_subcommand(1);
  AddLatency(app);
  AddMakeHead(app);
  AddAvatar(app);
  AddLandmarks(app);
  AddTrack(app);
  AddCheck(app);
  AddTrainAvatar(app);
  AddTrainScene(app);
  AddScene(app);
  AddRender(app);
  AddPlay(app);
  AddMetrics(app);
  AddExport(app);
  AddReport(app);
  AddInfo(app);
  AddSend(app);
  AddVoice(app);
  AddWebcam(app);
  AddStream(app);
  AddServe(app);
}

}  // namespace
}  // namespace cosplat

int main(int argc, char** argv) {
  return cosplat::RunProgram(
      "cosplat",
      "Direction-cosine splats: head avatars from tracked video, scenes from photographs.",
      cosplat::AddCommands,
      argc,
      argv);
}

// cosplat track: FLAME's parameters of a video, from its landmarks or from an earlier track.
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/run/refine_run.h"
#include "apps/cosplat/run/track_run.h"
#include "flame/track.h"
#include "splat/base/error.h"

namespace cosplat {

void DeclareTracking(TrackRunOptions& o, CLI::App& command) {
  command.add_option("--landmark-embedding",
                     o.embedding,
                     ".npz that says where the landmarks are on the model, if it is not FLAME");
  command.add_option("--focal", o.focal, "focal length in pixels, if it is known; 0: found")
      ->check(CLI::Range(0.0, 1e6));
  command.add_flag("--silhouette",
                   o.silhouette,
                   "draw the mesh's outline to the rims of the mattes, and offset it by the hair");
  command
      .add_option("--avatar-rounds",
                  o.avatar_rounds,
                  "at most so many rounds in which small avatars refine the track")
      ->check(CLI::Range(0, 20));
}

namespace {

void Track(const TrackRunOptions& o) {
  if (!o.landmarks.empty()) return RunTracking(o);
  if (TrackLayoutOf(o.source).empty())
    throw Error("--landmarks",
                "is missing, and '" + o.source +
                    "' is not a tracked video that could be refined: see `cosplat landmarks`");
  if (o.focal > 0 || !o.overlay.empty() || !o.embedding.empty() || o.silhouette)
    throw Error("--focal, --overlay, --landmark-embedding and --silhouette", "need --landmarks");
  RunRefinement({o.source, o.flame, o.out, o.avatar_rounds, o.quiet});
}

}  // namespace

void AddTrack(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "track",
      "fit FLAME to the landmarks of a video, or refine a track that there is: a folder for "
      "train-avatar");
  const auto o = std::make_shared<TrackRunOptions>();
  command
      ->add_option("video",
                   o->source,
                   "a video file, or a folder of images; or a tracked video, to be refined")
      ->required();
  command->add_option("--flame", o->flame, "FLAME model, .pkl or .npz")->required();
  command->add_option("-o,--out", o->out, "folder to write, in IMavatar's layout")->required();
  DeclareTracking(*o, *command);
  command->add_option(
      "--landmarks", o->landmarks, "the video's landmarks, see `cosplat landmarks`");
  command->add_option(
      "--overlay", o->overlay, "also write the mesh over every frame: .mp4 or folder");
  command->add_flag("--quiet", o->quiet, "print nothing but errors");
  command->callback([o] { Track(*o); });
}

}  // namespace cosplat

#include "assets/head/video.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>

#include "flame/io/imavatar_writer.h"
#include "flame/model.h"
#include "flame/pose.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

void Check(const MakeHeadOptions& o) {
  auto refuse = [](const std::string& field, int value, const std::string& expected) {
    throw Error("make-head", field, "is " + std::to_string(value) + ", expected " + expected);
  };
  if (o.frames < 1) refuse("frames", o.frames, "at least 1");
  if (o.test_frames < 0 || o.test_frames >= o.frames)
    refuse("test frames", o.test_frames, "0 or more and fewer than " + std::to_string(o.frames));
  if (o.size < 16 || o.size > 8192) refuse("size", o.size, "16 to 8192");
}

}  // namespace

void WriteProceduralVideo(const std::string& folder,
                          const MakeHeadOptions& options,
                          const std::function<void(int done, int total)>& progress) {
  Check(options);
  MakeDirectories(folder + "/image");
  MakeDirectories(folder + "/mask");
  RemoveFile(folder + "/flame_params.json");
  const ProceduralHead head = MakeProceduralHeadParts();
  const FlamePoser<float> poser(head.model, {});
  const auto script = procedural::MakeScript(
      {options.frames, options.test_frames, options.size, options.seed, options.frontal});
  TrackedVideo track;
  track.model_vertices = head.model.own_vertex_count();
  track.shape.assign(size_t(head.model.shape_count), 0);
  track.train.resize(script.size());
  std::vector<std::array<float, 4>> boxes(script.size());
  std::mutex mutex;
  int done = 0;
  tbb::parallel_for(size_t(0), script.size(), [&](size_t f) {
    std::vector<float> vertices;
    poser.Forward(FlamePoser<float>::ParametersOf(script[f].params), vertices);
    const Image8 image = RenderProceduralHead(head, vertices, script[f].params, script[f].camera);
    // If another frame could not be written, what is drawn in parallel ends early as well.
    if (tbb::is_current_task_group_canceling()) return;
    const Image8 mask = ChannelOf(image, 3);
    const std::string name = std::to_string(f + 1);
    WriteImage(folder + "/image/" + name + ".png", image);
    WriteImage(folder + "/mask/" + name + ".png", mask);
    track.train[f].name = name;
    track.train[f].camera = script[f].camera;
    track.train[f].params = script[f].params;
    boxes[f] = ImavatarBox(mask);
    const std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(done, int(script.size()));
  });
  WriteFlameModelNpz(folder + "/model.npz", head.model);
  WriteMadeLandmarks(folder, head, track.train, options);
  WriteImavatarTrack(folder, track, boxes, options.test_frames);
}

}  // namespace cosplat

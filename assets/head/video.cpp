#include "assets/head/video.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <mutex>

#include "flame/io/model_file.h"
#include "flame/pose.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/image_io.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

// The layout's mesh is the model's, enlarged by this factor.
constexpr float kMeshScale = 4;

void Check(const MakeHeadOptions& o) {
  auto refuse = [](const std::string& field, int value, const std::string& expected) {
    throw Error("make-head", field, "is " + std::to_string(value) + ", expected " + expected);
  };
  if (o.frames < 1) refuse("frames", o.frames, "at least 1");
  if (o.test_frames < 0 || o.test_frames >= o.frames)
    refuse("test frames", o.test_frames, "0 or more and fewer than " + std::to_string(o.frames));
  if (o.size < 16 || o.size > 8192) refuse("size", o.size, "16 to 8192");
}

Image8 AlphaOf(const Image8& rgba) {
  Image8 mask(rgba.width, rgba.height, 1);
  for (size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = rgba.data[4 * i + 3];
  return mask;
}

// Extent of the mask in the layout's format: left, top, right, bottom in [-1, 1].
std::array<float, 4> BoundingBox(const Image8& mask) {
  int x0 = mask.width, y0 = mask.height, x1 = 0, y1 = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (mask.at(x, y, 0) == 0) continue;
      x0 = std::min(x0, x), x1 = std::max(x1, x + 1);
      y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
    }
  auto norm = [](int p, int size) { return 2.0f * float(p) / float(size) - 1; };
  return {norm(x0, mask.width), norm(y0, mask.height), norm(x1, mask.width), norm(y1, mask.height)};
}

// In OpenGL's camera axes and for the enlarged mesh: rows 1 and 2 change sign, the translation is
// scaled.
Json WorldMatrix(const Camera& camera) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    const float sign = r == 0 ? 1.0f : -1.0f;
    rows.push_back({sign * camera.rotation[3 * r],
                    sign * camera.rotation[3 * r + 1],
                    sign * camera.rotation[3 * r + 2],
                    sign * kMeshScale * camera.translation[r]});
  }
  return rows;
}

Json FrameJson(int number, const procedural::ScriptFrame& frame, const std::array<float, 4>& bbox) {
  Json pose = Json::array();
  for (const auto& joint : frame.params.pose)
    for (float x : joint) pose.push_back(x);
  return {{"file_path", "./image/" + std::to_string(number)},
          {"world_mat", WorldMatrix(frame.camera)},
          {"expression", frame.params.expression},
          {"pose", pose},
          {"bbox", bbox}};
}

}  // namespace

void WriteProceduralVideo(const std::string& folder,
                          const MakeHeadOptions& options,
                          const std::function<void(int done, int total)>& progress) {
  Check(options);
  MakeDirectories(folder + "/image");
  MakeDirectories(folder + "/mask");
  std::filesystem::remove(folder + "/flame_params.json");
  const ProceduralHead head = MakeProceduralHeadParts();
  const FlamePoser<float> poser(head.model, {});
  const auto script =
      procedural::MakeScript({options.frames, options.test_frames, options.size, options.seed});
  std::vector<std::array<float, 4>> boxes(script.size());
  std::mutex mutex;
  int done = 0;
  tbb::parallel_for(size_t(0), script.size(), [&](size_t f) {
    std::vector<float> vertices;
    poser.Forward(FlamePoser<float>::ParametersOf(script[f].params), vertices);
    const Image8 image = RenderProceduralHead(head, vertices, script[f].params, script[f].camera);
    const Image8 mask = AlphaOf(image);
    const std::string name = std::to_string(f + 1) + ".png";
    WriteImage(folder + "/image/" + name, image);
    WriteImage(folder + "/mask/" + name, mask);
    boxes[f] = BoundingBox(mask);
    const std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(done, int(script.size()));
  });
  WriteFlameModelNpz(folder + "/model.npz", head.model);
  const Camera& lens = script[0].camera;
  const float size = float(options.size);
  Json json{{"intrinsics", {-lens.fx / size, lens.fy / size, lens.cx / size, lens.cy / size}},
            {"shape_params", std::vector<float>(head.model.shape_count, 0.0f)},
            {"test_frames", options.test_frames},
            {"frames", Json::array()}};
  for (size_t f = 0; f < script.size(); ++f)
    json["frames"].push_back(FrameJson(int(f) + 1, script[f], boxes[f]));
  WriteFileAtomically(folder + "/flame_params.json", json.dump(1) + "\n");
}

}  // namespace cosplat

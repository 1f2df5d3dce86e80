#include "apps/cosplat/run/head_sheets.h"

#include "assets/head/motion.h"
#include "assets/head/procedural_head.h"
#include "avatar/model/blendshape_map.h"
#include "flame/pose.h"
#include "splat/base/files.h"
#include "splat/base/rng.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

constexpr int kSide = 160;  // px, of a tile
constexpr float kZoom = 1.2f, kLower = 0.12f;
constexpr size_t kColumns = 13, kPeople = 24;
constexpr uint64_t kSeed = 1;  // of the people

void CopyInto(const Image8& tile, int left, int top, Image8& sheet) {
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const uint8_t* from = &tile.data[4 * (size_t(y) * size_t(tile.width) + size_t(x))];
      uint8_t* to = &sheet.data[3 * (size_t(top + y) * size_t(sheet.width) + size_t(left + x))];
      for (size_t c = 0; c < 3; ++c)
        to[c] = uint8_t((from[c] * from[3] + 255 * (255 - from[3])) / 255);
    }
}

// faces: parameters, with their own shape.
Image8 SheetOf(const ProceduralHead& head, const std::vector<FlameParams>& faces) {
  Camera camera = procedural::OrbitCamera(0.35f, 0.05f, 0.75f, kSide);
  camera.fx *= kZoom;
  camera.fy *= kZoom;
  camera.cy += kLower * kSide;  // the head in the middle instead of its neck
  const int rows = int((faces.size() + kColumns - 1) / kColumns);
  Image8 sheet(kSide * int(kColumns), kSide * rows, 3, 255);
  for (size_t i = 0; i < faces.size(); ++i) {
    const FlamePoser<float> poser(head.model, faces[i].shape);
    std::vector<float> vertices;
    poser.Forward(FlamePoser<float>::ParametersOf(faces[i]), vertices);
    CopyInto(RenderProceduralHead(head, vertices, faces[i], camera),
             kSide * int(i % kColumns),
             kSide * int(i / kColumns),
             sheet);
  }
  return sheet;
}

}  // namespace

void WriteHeadSheets(const std::string& folder) {
  const ProceduralHead head = MakeHeadForPeopleParts();
  const BlendshapeMap map = GeneralBlendshapeMap(&head.model);
  std::vector<FlameParams> expressions, shapes, people(kPeople);
  for (const std::string_view name : kArkitNames) {
    BlendshapeScores scores{{std::string(name), 1.0f}};
    if (name == "mouthClose") scores["jawOpen"] = 1;
    ApplyBlendshapes(map, scores, expressions.emplace_back());
  }
  for (size_t k = 0; k < size_t(head.model.shape_count); ++k)
    for (const float amount : {-2.0f, 2.0f}) {
      shapes.emplace_back().shape.resize(k + 1);
      shapes.back().shape[k] = amount;
    }
  Rng rng{kSeed};
  for (FlameParams& person : people)
    for (int k = 0; k < head.model.shape_count; ++k) person.shape.push_back(float(rng.Normal()));
  MakeDirectories(folder);
  WriteImage(folder + "/expressions.png", SheetOf(head, expressions));
  WriteImage(folder + "/shapes.png", SheetOf(head, shapes));
  WriteImage(folder + "/people.png", SheetOf(head, people));
}

}  // namespace cosplat

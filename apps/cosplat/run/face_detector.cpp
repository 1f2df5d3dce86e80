#include "apps/cosplat/run/face_detector.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/process.h"
#include "splat/base/text.h"
#include "splat/media/image_io.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

std::string MakeScratchFolder() {
  std::string name = (fs::temp_directory_path() / "cosplat-landmarks-XXXXXX").string();
  if (!mkdtemp(name.data())) throw Error(name, "cannot be created");
  return name;
}

DetectedFace FaceIn(const JsonField& field) {
  DetectedFace face;
  for (size_t p = 0; p < field.size(); ++p)
    face.points.push_back({field[p][0].Number(), field[p][1].Number()});
  return face;
}

}  // namespace

FaceDetector::FaceDetector(int width, int height, bool quiet)
    : width_(width),
      height_(height),
      mediapipe_(FindMediapipe(quiet)),
      folder_(MakeScratchFolder()) {}

FaceDetector::~FaceDetector() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void FaceDetector::Add(size_t image, const Image8& pixels) const {
  WriteImage(File(std::to_string(image) + ".jpg"), pixels);
}

void FaceDetector::Run(const std::vector<double>& milliseconds,
                       bool mattes,
                       const std::function<void(int done)>& progress) {
  WriteFileAtomically(File("times.json"), Json(milliseconds).dump());
  std::string last;
  const int status = RunProcess(mediapipe_.Command("detect.mjs",
                                                   {"--frames",
                                                    folder_,
                                                    "--jobs",
                                                    mattes ? "face,matte" : "face,face",
                                                    "--width",
                                                    std::to_string(width_),
                                                    "--height",
                                                    std::to_string(height_)}),
                                {},
                                [&](const std::string& line) {
                                  int done = 0;
                                  if (std::sscanf(line.c_str(), "frame %d", &done) == 1)
                                    progress(std::clamp(done, 0, int(milliseconds.size())));
                                  else if (!line.empty())
                                    last = line;
                                });
  if (status != 0)
    throw Error("landmarks", "node " + ExitText(status) + (last.empty() ? "" : ": " + last));
}

std::vector<std::vector<DetectedFace>> FaceDetector::Faces() const {
  const JsonField found(File("faces.json"), ReadJson(File("faces.json")));
  std::vector<std::vector<DetectedFace>> faces(found.size());
  for (size_t f = 0; f < faces.size(); ++f)
    for (size_t i = 0; i < found[f].size(); ++i) faces[f].push_back(FaceIn(found[f][i]));
  return faces;
}

// The browser's mattes are a byte per pixel, rows from the top.
Image8 FaceDetector::Matte(size_t image) const {
  const std::string path = File(std::to_string(image) + ".matte");
  const std::vector<char> bytes = ReadFile(path);
  Image8 matte(width_, height_, 1);
  if (bytes.size() != matte.data.size())
    throw Error(path, Format("has {} bytes, expected {}", bytes.size(), matte.data.size()));
  std::copy(bytes.begin(), bytes.end(), matte.data.begin());
  return matte;
}

Image8 FaceDetector::Added(size_t image) const {
  return ReadImage(File(std::to_string(image) + ".jpg"));
}

}  // namespace cosplat

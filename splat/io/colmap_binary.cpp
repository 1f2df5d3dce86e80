#include <cstring>
#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/io/colmap_model.h"

namespace cosplat::colmap {
namespace {

// Reads little-endian numbers in order; errors at the end of the file name the current record.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), bytes_(ReadFile(path)) {}

  // Sets the current record, for messages.
  void Enter(const std::string& kind, uint64_t index, uint64_t count) {
    record_ = kind + " " + std::to_string(index + 1) + " of " + std::to_string(count);
  }

  template <class T>
  T Get(const char* what) {
    T value;
    Require(sizeof(T), what);
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  std::string Text(const char* what) {
    const void* end = std::memchr(bytes_.data() + at_, 0, bytes_.size() - at_);
    if (end == nullptr) Require(bytes_.size() - at_ + 1, what);
    std::string text(bytes_.data() + at_);
    at_ += text.size() + 1;
    return text;
  }

  void Skip(uint64_t count, uint64_t size, const char* what) {
    if (count > (uint64_t(1) << 40)) Require(uint64_t(1) << 40, what);
    Require(count * size, what);
    at_ += count * size;
  }

  uint64_t Count(const char* what) {
    record_ = "header";
    return Get<uint64_t>(what);
  }

  std::string Field() const { return record_; }

  void ExpectEnd() const {
    if (at_ != bytes_.size())
      throw Error(path_, std::to_string(bytes_.size() - at_) + " bytes follow the last record");
  }

 private:
  void Require(uint64_t size, const char* what) const {
    if (bytes_.size() - at_ < size)
      throw Error(
          path_, record_, Format("the file ends at byte {}, expected {}", bytes_.size(), what));
  }

  std::string path_;
  std::vector<char> bytes_;
  size_t at_ = 0;
  std::string record_;
};

void ReadCamerasBinary(const std::string& path, ColmapModel& model) {
  Reader in(path);
  const uint64_t count = in.Count("the number of cameras");
  for (uint64_t i = 0; i < count; ++i) {
    in.Enter("camera", i, count);
    const uint32_t id = in.Get<uint32_t>("a camera id");
    const int model_id = in.Get<int32_t>("a camera model");
    const ColmapModelKind* kind = FindColmapModelKind(model_id);
    if (kind == nullptr)
      throw Error(path, in.Field(), "camera model " + std::to_string(model_id) + " is unknown");
    const int64_t width = in.Get<int64_t>("an image width");
    const int64_t height = in.Get<int64_t>("an image height");
    std::vector<double> params(kind->params);
    for (double& p : params) p = in.Get<double>("camera parameters");
    model.cameras[id] = MakeColmapCamera(path, in.Field(), kind->name, {width, height}, params);
  }
  in.ExpectEnd();
}

void ReadImagesBinary(const std::string& path, ColmapModel& model) {
  Reader in(path);
  const uint64_t count = in.Count("the number of images");
  for (uint64_t i = 0; i < count; ++i) {
    in.Enter("image", i, count);
    ColmapImage image;
    in.Get<uint32_t>("an image id");
    for (double& q : image.rotation) q = in.Get<double>("a rotation");
    for (double& t : image.translation) t = in.Get<double>("a translation");
    image.camera_id = in.Get<uint32_t>("a camera id");
    image.name = in.Text("an image name");
    const uint64_t observations = in.Get<uint64_t>("the number of 2D points");
    in.Skip(observations, 24, "2D points");
    model.images.push_back(std::move(image));
  }
  in.ExpectEnd();
}

void ReadPointsBinary(const std::string& path, ColmapModel& model) {
  Reader in(path);
  const uint64_t count = in.Count("the number of points");
  MeanError mean;
  for (uint64_t i = 0; i < count; ++i) {
    in.Enter("point", i, count);
    in.Get<uint64_t>("a point id");
    for (int k = 0; k < 3; ++k) model.points.push_back(in.Get<double>("a position"));
    for (int k = 0; k < 3; ++k) model.point_colors.push_back(in.Get<uint8_t>("a colour"));
    mean.Add(in.Get<double>("an error"));
    const uint64_t track = in.Get<uint64_t>("a track length");
    in.Skip(track, 8, "a track");
  }
  model.mean_error = mean.Mean();
  in.ExpectEnd();
}

}  // namespace

void ReadBinary(const std::string& folder, ColmapModel& model) {
  ReadCamerasBinary(folder + "/cameras.bin", model);
  ReadImagesBinary(folder + "/images.bin", model);
  const std::string points = folder + "/points3D.bin";
  if (std::filesystem::exists(points)) ReadPointsBinary(points, model);
}

}  // namespace cosplat::colmap

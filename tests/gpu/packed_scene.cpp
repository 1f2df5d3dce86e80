#include "tests/gpu/packed_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "splat/base/error.h"

namespace cosplat::test {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view kMagic = "CoSplat scene 1\n";
constexpr int kMaxSide = 1 << 16;

struct Header {
  uint32_t train, test, points, white;
  float extent;
};

struct ViewHeader {
  int32_t width, height, channels;
  float fx, fy, cx, cy, rotation[9], translation[3];
};
static_assert(sizeof(Header) == 20 && sizeof(ViewHeader) == 76);

// Where plane p of an image is: a channel, less green where it is red or blue.
struct Plane {
  int channel;
  bool less_green;
};
Plane PlaneOf(int channels, int p) {
  constexpr Plane kPlanes[] = {{3, false}, {1, false}, {0, true}, {2, true}};
  return kPlanes[p + (channels == 4 ? 0 : 1)];
}

uint8_t Predicted(const std::vector<uint8_t>& plane, size_t i, int x, int width, bool first_row) {
  const int a = x > 0 ? plane[i - 1] : 0;
  const int b = first_row ? 0 : plane[i - size_t(width)];
  const int c = x > 0 && !first_row ? plane[i - size_t(width) - 1] : 0;
  return uint8_t(std::clamp(a + b - c, std::min(a, b), std::max(a, b)));
}

void WriteImage(std::ostream& out, const Image8& image) {
  std::vector<uint8_t> plane(image.pixels()), left(image.pixels());
  for (int p = 0; p < image.channels; ++p) {
    const Plane from = PlaneOf(image.channels, p);
    for (size_t i = 0; i < plane.size(); ++i) {
      const uint8_t* pixel = &image.data[i * size_t(image.channels)];
      plane[i] = uint8_t(pixel[from.channel] - (from.less_green ? pixel[1] : 0));
    }
    for (size_t i = 0; i < plane.size(); ++i)
      left[i] = uint8_t(
          plane[i] -
          Predicted(plane, i, int(i % size_t(image.width)), image.width, i < size_t(image.width)));
    out.write(reinterpret_cast<const char*>(left.data()), std::streamsize(left.size()));
  }
}

// A file that is read from its beginning; nothing is allocated that it cannot fill.
class Input {
 public:
  explicit Input(const std::string& path) : path_(path), file_(path, std::ios::binary) {
    std::error_code error;
    left_ = std::filesystem::file_size(path, error);
    if (!file_ || error) throw Error(path, "", "cannot be read");
  }
  template <class T>
  std::vector<T> Take(size_t count, const char* field) {
    if (count > left_ / sizeof(T)) throw Error(path_, field, "the file ends before it");
    std::vector<T> values(count);
    file_.read(reinterpret_cast<char*>(values.data()), std::streamsize(count * sizeof(T)));
    if (!file_) throw Error(path_, field, "cannot be read");
    left_ -= count * sizeof(T);
    return values;
  }
  [[noreturn]] void Refuse(const std::string& field, const std::string& problem) const {
    throw Error(path_, field, problem);
  }
  size_t left() const { return left_; }

 private:
  std::string path_;
  std::ifstream file_;
  size_t left_ = 0;
};

Image8 ReadImage(Input& in, const ViewHeader& view) {
  Image8 image(view.width, view.height, view.channels);
  std::vector<uint8_t> planes[4];
  for (int p = 0; p < view.channels; ++p) {
    std::vector<uint8_t> plane = in.Take<uint8_t>(image.pixels(), "images");
    for (size_t i = 0; i < plane.size(); ++i)
      plane[i] = uint8_t(
          plane[i] +
          Predicted(plane, i, int(i % size_t(view.width)), view.width, i < size_t(view.width)));
    planes[PlaneOf(view.channels, p).channel] = std::move(plane);
  }
  for (int p = 0; p < view.channels; ++p) {
    const Plane to = PlaneOf(view.channels, p);
    for (size_t i = 0; i < image.pixels(); ++i)
      image.data[i * size_t(view.channels) + size_t(to.channel)] =
          uint8_t(planes[to.channel][i] + (to.less_green ? planes[1][i] : 0));
  }
  return image;
}

void Check(const Input& in, const ViewHeader& view, const std::string& field) {
  const auto side = [](int32_t s) { return s >= 1 && s <= kMaxSide; };
  if (!side(view.width) || !side(view.height) || (view.channels != 3 && view.channels != 4))
    in.Refuse(field,
              "is of " + std::to_string(view.width) + "x" + std::to_string(view.height) + "x" +
                  std::to_string(view.channels));
  if (!(view.fx > 0) || !(view.fy > 0)) in.Refuse(field, "its focal length is not positive");
  const float* numbers = &view.fx;
  if (!std::all_of(numbers, numbers + 16, [](float x) { return std::isfinite(x); }))
    in.Refuse(field, "its camera is not finite");
}

Camera CameraOf(const ViewHeader& view) {
  Camera camera;
  camera.width = view.width;
  camera.height = view.height;
  camera.fx = view.fx;
  camera.fy = view.fy;
  camera.cx = view.cx;
  camera.cy = view.cy;
  std::copy_n(view.rotation, 9, camera.rotation.begin());
  std::copy_n(view.translation, 3, camera.translation.begin());
  return camera;
}

ViewHeader HeaderOf(const TrainFrame& frame) {
  const Camera& c = frame.camera;
  ViewHeader view{c.width, c.height, frame.target.channels, c.fx, c.fy, c.cx, c.cy, {}, {}};
  std::copy_n(c.rotation.begin(), 9, view.rotation);
  std::copy_n(c.translation.begin(), 3, view.translation);
  return view;
}

template <class T>
void Put(std::ostream& out, const T* values, size_t count) {
  out.write(reinterpret_cast<const char*>(values), std::streamsize(count * sizeof(T)));
}

}  // namespace

void WritePackedScene(std::ostream& out, const TrainingScene& scene) {
  out << kMagic;
  const Header header{uint32_t(scene.train.size()),
                      uint32_t(scene.test.size()),
                      uint32_t(scene.points.size() / 3),
                      scene.renderings,
                      scene.extent};
  Put(out, &header, 1);
  Put(out, scene.points.data(), scene.points.size());
  Put(out, scene.point_colors.data(), scene.point_colors.size());
  for (const auto* frames : {&scene.train, &scene.test})
    for (const TrainFrame& frame : *frames) {
      const ViewHeader view = HeaderOf(frame);
      Put(out, &view, 1);
    }
  for (const auto* frames : {&scene.train, &scene.test})
    for (const TrainFrame& frame : *frames) WriteImage(out, frame.target);
}

TrainingScene ReadPackedScene(const std::string& path) {
  Input in(path);
  const std::vector<char> magic = in.Take<char>(kMagic.size(), "header");
  if (std::string_view(magic.data(), magic.size()) != kMagic) in.Refuse("", "is no packed scene");
  const Header header = in.Take<Header>(1, "header")[0];
  if (header.train == 0) in.Refuse("training views", "there is none");
  if (!(header.extent > 0) || !std::isfinite(header.extent))
    in.Refuse("extent", "is not positive: " + std::to_string(header.extent));
  TrainingScene scene;
  scene.extent = header.extent;
  scene.renderings = header.white != 0;
  scene.points = in.Take<float>(3 * size_t(header.points), "points");
  scene.point_colors = in.Take<uint8_t>(3 * size_t(header.points), "colours of points");
  const size_t count = size_t(header.train) + header.test;
  const std::vector<ViewHeader> views = in.Take<ViewHeader>(count, "cameras");
  size_t images = 0;
  for (size_t i = 0; i < count; ++i) {
    Check(in, views[i], "view " + std::to_string(i));
    images += size_t(views[i].width) * size_t(views[i].height) * size_t(views[i].channels);
  }
  if (images != in.left())
    in.Refuse("images",
              std::to_string(in.left()) + " bytes are left, expected " + std::to_string(images));
  for (size_t i = 0; i < count; ++i)
    (i < header.train ? scene.train : scene.test)
        .push_back({CameraOf(views[i]), ReadImage(in, views[i])});
  return scene;
}

}  // namespace cosplat::test

// metrical-tracker's checkpoints of tests/flame/tracked_head.h, as torch.save writes them.
#pragma once

#include <map>
#include <string>

#include "splat/base/files.h"
#include "splat/media/image_io.h"
#include "tests/flame/pickle_builder.h"
#include "tests/flame/tracked_head.h"
#include "tests/support/stored_zip.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

inline std::string FrameName(int i) {
  const std::string number = std::to_string(i);
  return std::string(5 - number.size(), '0') + number;
}

// The first two rows of a rotation, not normalised.
inline std::vector<float> SixNumbers(const Vec3<double>& axis_angle) {
  const Mat3<double> r = flame_math::Rodrigues(axis_angle);
  std::vector<float> six;
  for (int k = 0; k < 6; ++k) six.push_back(float((k < 3 ? 1.3 : 0.8) * r.m[k]));
  return six;
}

// The values of a checkpoint, to be changed before it is written: array name -> (shape, numbers).
struct MetricalValues {
  struct Array {
    std::vector<int> shape;
    std::vector<float> numbers;
  };
  std::map<std::string, Array> flame, camera, opencv;
  std::vector<int64_t> img_size = {kHeadSide, kHeadSide};
};

inline MetricalValues MetricalAt(const FlameModel& model, int i) {
  const HeadFrame frame = HeadAt(i);
  const HeadCamera camera = CameraAboutHead(model, frame);
  MetricalValues values;
  std::vector<float> shape = HeadShape();
  values.flame["shape"] = {{1, int(shape.size())}, shape};
  values.flame["exp"] = {{1, int(frame.expression.size())}, frame.expression};
  values.flame["jaw"] = {{1, 6}, SixNumbers(frame.jaw)};
  std::vector<float> eyes = SixNumbers(frame.left_eye);
  const std::vector<float> right = SixNumbers(frame.right_eye);
  eyes.insert(eyes.end(), right.begin(), right.end());
  values.flame["eyes"] = {{1, 12}, eyes};
  values.flame["eyelids"] = {{1, 2}, {frame.eyelids[0], frame.eyelids[1]}};
  values.flame["tex"] = {{1, 2}, {0, 0}};
  // PyTorch3D's camera: x left, y up, row vectors, and lengths in halves of the image's side.
  // Rotation p = x R + T with R the transposed rows of OpenCV's, the first two negated.
  const double half = kHeadSide / 2.0;
  std::vector<float> six, t;
  const auto& r = camera.rotation;
  for (int row = 0; row < 2; ++row)
    for (int k = 0; k < 3; ++k) six.push_back(float((k < 2 ? -1 : 1) * r(k, row)));
  for (int k = 0; k < 3; ++k) t.push_back(float((k < 2 ? -1 : 1) * camera.translation[k]));
  values.camera["R"] = {{1, 6}, six};
  values.camera["t"] = {{1, 3}, t};
  values.camera["fl"] = {{1, 1}, {float(kHeadFocal / half)}};
  values.camera["pp"] = {
      {1, 2}, {float((half - kHeadCenter[0]) / half), float((half - kHeadCenter[1]) / half)}};
  std::vector<float> rotation(r.m, r.m + 9);
  values.opencv["R"] = {{1, 3, 3}, rotation};
  values.opencv["t"] = {
      {1, 3},
      {float(camera.translation[0]), float(camera.translation[1]), float(camera.translation[2])}};
  values.opencv["K"] = {{1, 3, 3},
                        {float(kHeadFocal),
                         0,
                         float(kHeadCenter[0]),
                         0,
                         float(kHeadFocal),
                         float(kHeadCenter[1]),
                         0,
                         0,
                         1}};
  return values;
}

// A torch archive of a pickle.
inline std::string TorchArchive(const std::string& root_value) {
  return StoredZip({{"archive/data.pkl", pickle::File(root_value)},
                    {"archive/byteorder", "little"},
                    {"archive/version", "3\n"},
                    {"archive/.data/serialization_id", "123"}});
}

inline std::string MetricalPickle(const MetricalValues& values) {
  using Group = std::map<std::string, MetricalValues::Array>;
  const auto group = [](const Group& arrays) {
    std::vector<std::pair<std::string, std::string>> items;
    for (const auto& [name, array] : arrays)
      items.emplace_back(name, pickle::Floats(array.shape, array.numbers));
    return pickle::Dict(items);
  };
  return pickle::Dict({{"flame", group(values.flame)},
                       {"camera", group(values.camera)},
                       {"opencv", group(values.opencv)},
                       {"img_size",
                        pickle::Array({int(values.img_size.size())},
                                      pickle::Dtype("i8"),
                                      pickle::Bytes(pickle::Raw(values.img_size)))},
                       {"frame_id", pickle::Text("00000")},
                       {"global_step", pickle::Int(7)}});
}

// A folder of the tracker's output.
struct Metrical {
  const FlameModel model = HeadModel();
  TemporaryFolder folder;
  std::map<int, MetricalValues> frames;

  explicit Metrical(int count = kHeadFrames) {
    for (int i = 0; i < count; ++i) frames[i] = MetricalAt(model, i);
  }
  void WriteCheckpoint(int i, const std::string& bytes) const {
    MakeDirectories(folder / "checkpoint");
    WriteFileAtomically(folder / ("checkpoint/" + FrameName(i) + ".frame"), bytes);
  }
  void WriteImages(const std::string& name, int channels, int side = 32) const {
    MakeDirectories(folder / name);
    for (const auto& [i, values] : frames)
      WriteImage(folder / (name + "/" + FrameName(i) + ".png"),
                 Image8(side, side, channels, uint8_t(10 * i + 1)));
  }
  const std::string& Write() const {
    for (const auto& [i, values] : frames) WriteCheckpoint(i, TorchArchive(MetricalPickle(values)));
    return folder.path();
  }
};

}  // namespace cosplat::test

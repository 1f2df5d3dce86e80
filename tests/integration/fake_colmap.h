// A made room's photographs, and a program in COLMAP's place that does as it is told: with the
// options of one version, refusing others as that version does.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "splat/math/quat.h"
#include "tests/integration/command.h"

namespace cosplat::test {

namespace fs = std::filesystem;

// A room of textured walls, [-2, 2]^3, photographed along a curve before its far wall.
constexpr int kViews = 10;

struct MadePose {
  double center[3];
  math::Quat<double> rotation;  // cam_from_world; y is down
};
// Looks at (0, 0, 1.5). With turns about more than one axis: about a single one, focal lengths
// could not be found.
inline MadePose PoseOf(int i) {
  const double x = -1.2 + 2.4 * i / (kViews - 1), y = std::sin(2.0 * i), z = -1.3 + 0.1 * (i % 3);
  const double yaw = std::atan2(-x, 1.5 - z) / 2,
               pitch = std::atan2(-y, std::hypot(x, 1.5 - z)) / 2;
  const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
  return {{x, y, z}, {cp * cy, sp * cy, -cp * sy, -sp * sy}};
}

inline Camera CameraOf(int i, int width) {
  const MadePose p = PoseOf(i);
  const math::Mat3<double> rotation = math::RotationOf(p.rotation);
  Camera camera;
  camera.width = width;
  camera.height = width * 3 / 4;
  camera.fx = camera.fy = 0.9f * float(width);
  camera.cx = 0.5f * float(width);
  camera.cy = 0.375f * float(width);
  for (int k = 0; k < 9; ++k) camera.rotation[k] = float(rotation(k / 3, k % 3));
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      camera.translation[k] -= camera.rotation[3 * k + j] * float(p.center[j]);
  return camera;
}

inline double Hash(int a, int b, int c) {
  uint32_t h = uint32_t(a) * 0x9e3779b1u ^ uint32_t(b) * 0x85ebca6bu ^ uint32_t(c) * 0xc2b2ae35u;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  h = (h ^ h >> 12) * 0x297a2d39u;
  return (h ^ h >> 15) / 4294967296.0;
}

// Patches of two sizes, different on every wall and in every channel.
inline double Texture(int wall, double u, double v, int channel) {
  const auto patch = [&](double size, int salt) {
    return Hash(int(std::floor(u / size)), int(std::floor(v / size)), wall * 8 + channel + salt);
  };
  return 255 * (0.5 * patch(0.31, 0) + 0.5 * patch(0.09, 64));
}

inline Image8 Photograph(int i, int width) {
  const Camera camera = CameraOf(i, width);
  const MadePose pose = PoseOf(i);
  constexpr int kSamples = 3;  // per pixel and axis
  Image8 image(camera.width, camera.height, 3);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      double sum[3] = {};
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double dx = (x + (s % kSamples + 0.5) / kSamples - camera.cx) / camera.fx;
        const double dy = (y + (s / kSamples + 0.5) / kSamples - camera.cy) / camera.fy;
        double d[3], nearest = 1e9, at[3];
        for (int k = 0; k < 3; ++k)
          d[k] = camera.rotation[k] * dx + camera.rotation[3 + k] * dy + camera.rotation[6 + k];
        int wall = 0;
        for (int k = 0; k < 3; ++k) {
          const double t = ((d[k] > 0 ? 2 : -2) - pose.center[k]) / d[k];
          if (t < nearest) nearest = t, wall = 2 * k + (d[k] > 0);
        }
        for (int k = 0; k < 3; ++k) at[k] = pose.center[k] + nearest * d[k];
        for (int c = 0; c < 3; ++c)
          sum[c] += Texture(wall, at[(wall / 2 + 1) % 3], at[(wall / 2 + 2) % 3], c);
      }
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = uint8_t(sum[c] / (kSamples * kSamples));
    }
  return image;
}

inline std::string NameOf(int i) { return "p" + std::to_string(i) + ".png"; }

inline void WritePhotographs(const std::string& folder, int width, int count = kViews) {
  fs::create_directories(folder);
  for (int i = 0; i < count; ++i) WriteImage(folder + "/" + NameOf(i), Photograph(i, width));
}

// A model in COLMAP's text format of the first `count` photographs, whose points have the error
// (px).
inline void WriteModel(const std::string& folder, int width, int count, const char* error = "0.5") {
  fs::create_directories(folder);
  const Camera c = CameraOf(0, width);
  std::ofstream(folder + "/cameras.txt")
      << "1 PINHOLE " << c.width << " " << c.height << " " << c.fx << " " << c.fy << " " << c.cx
      << " " << c.cy << "\n";
  std::ofstream images(folder + "/images.txt"), points(folder + "/points3D.txt");
  for (int i = 0; i < count; ++i) {
    const Camera camera = CameraOf(i, width);
    const auto [w, x, y, z] = PoseOf(i).rotation;
    images << i + 1 << " " << w << " " << x << " " << y << " " << z;
    for (const float t : camera.translation) images << " " << t;
    images << " 1 " << NameOf(i) << "\n\n";
  }
  for (int i = 0; i < 200; ++i)
    points << i + 1 << " " << 4 * Hash(i, 1, 0) - 2 << " " << 4 * Hash(i, 2, 0) - 2
           << " 2 128 128 128 " << error << "\n";
}

// Options of the commands, as `colmap COMMAND -h` lists them; of 4.2.1 those of SIFT.
enum class Dialect { k38, k42 };
inline std::string OptionsIn(Dialect dialect, const std::string& command) {
  const bool is_new = dialect == Dialect::k42;
  const std::string common =
      is_new ? "project_path default_random_seed log_target log_path log_level log_color "
             : "random_seed log_to_stderr log_level project_path ";
  if (command == "feature_extractor")
    return common +
           "database_path image_path camera_mode ImageReader.camera_model "
           "ImageReader.single_camera ImageReader.single_camera_per_folder " +
           (is_new ? "FeatureExtraction.type FeatureExtraction.num_threads "
                     "FeatureExtraction.use_gpu FeatureExtraction.max_image_size "
                     "SiftExtraction.max_num_features AlikedExtraction.n16rot_model_path"
                   : "SiftExtraction.num_threads SiftExtraction.use_gpu "
                     "SiftExtraction.max_image_size SiftExtraction.max_num_features");
  if (command == "exhaustive_matcher" || command == "sequential_matcher")
    return common + "database_path " +
           (is_new ? "FeatureMatching.type FeatureMatching.num_threads FeatureMatching.use_gpu "
                     "SiftMatching.max_ratio "
                   : "SiftMatching.num_threads SiftMatching.use_gpu SiftMatching.max_ratio ") +
           (command[0] == 'e' ? "ExhaustiveMatching.block_size"
                              : "SequentialMatching.overlap SequentialMatching.quadratic_overlap");
  if (command == "mapper")
    return common +
           "database_path image_path input_path output_path Mapper.num_threads "
           "Mapper.init_min_tri_angle";
  return common + "image_path input_path output_path output_type max_image_size";
}

// Photographs, and a program that takes COLMAP's arguments, writes them to `calls` and the model to
// where COLMAP would.
struct FakeColmap {
  static constexpr int kWidth = 48;
  TemporaryFolder folder;
  std::string photographs = folder / "photographs", out = folder / "out", calls = folder / "calls",
              questions = folder / "questions", program = folder / "bin/colmap";
  Dialect dialect;

  explicit FakeColmap(int registered = kViews, Dialect version = Dialect::k38) : dialect(version) {
    WritePhotographs(photographs, kWidth);
    WriteModel(folder / "model", kWidth, registered);
    fs::create_directories(folder / "bin");
    WriteProgram("");
  }

  // `misbehave`: run first, with $command and the arguments.
  void WriteProgram(const std::string& misbehave) const {
    const bool is_new = dialect == Dialect::k42;
    std::ofstream script(program);
    script << "#!/bin/sh\ncase $1 in\n";
    std::string commands;
    for (const char* command : {"feature_extractor",
                                "exhaustive_matcher",
                                "sequential_matcher",
                                "mapper",
                                "image_undistorter"}) {
      commands += std::string("  ") + command + "\n";
      script << command << ") options='" << OptionsIn(dialect, command) << "';;\n";
    }
    if (is_new) commands += "  global_mapper\n";
    script << "help) echo \"$@\" >> '" << questions << "'; echo 'COLMAP "
           << (is_new ? "4.2.1" : "3.8")
           << " -- Structure-from-Motion'\necho 'Available commands:\n"
           << commands << "'; exit 0;;\nesac\n"
           << "if [ \"$2\" = -h ]; then echo \"$@\" >> '" << questions
           << "'; for option in $options; do echo \"  --$option arg (=0)\"; done; exit 0; fi\n"
           << "echo \"$@\" >> '" << calls << "'\ncommand=$1; shift\n"
           << "while [ $# -gt 1 ]; do case \" $options \" in *\" ${1#--} \"*) ;; *) printf '"
           << (is_new ? "\\033[31mE2026 base_option_manager.cc:265] " : "ERROR: ")
           << "Failed to parse options - unrecognised option %s." << (is_new ? "\\033[0m" : "")
           << "\\n' \"$1\" >&2; exit 1;; esac\n"
           << "case $1 in --image_path) images=$2;; --output_path) "
              "output=$2;; --database_path) database=$2;; esac; shift 2; done\n"
           << misbehave << "\ncase $command in\n"
           << "feature_extractor) echo 'Processed file [3/10]'; echo made >> \"$database\";;\n"
           << "*_matcher) echo 'Matching block [1/1, 1/1] in 0.1s';;\n"
           << "mapper) echo 'Registering image #2 (" << (is_new ? "num_reg_frames=3" : "3")
           << ")'; mkdir \"$output/0\"; cp '" << folder / "model"
           << "'/* \"$output/0\";;\n"
           << "image_undistorter) mkdir \"$output/images\" \"$output/sparse\" \"$output/stereo\"\n"
           << "cp -rL \"$images/.\" \"$output/images\"; cp '" << folder / "model"
           << "'/* \"$output/sparse\";;\nesac\n";
    script.close();
    fs::permissions(program, fs::perms::owner_all);
  }

  CommandResult Run(std::vector<std::string> more = {}, const std::string& source = "") const {
    std::vector<std::string> arguments{"scene",
                                       source.empty() ? photographs : source,
                                       "-o",
                                       out,
                                       "--colmap",
                                       program,
                                       "--iterations",
                                       "30",
                                       "--sh_degree",
                                       "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Cosplat(arguments);
  }

  // The commands so far, and then none; likewise what it was asked.
  std::vector<std::string> TakeCalls() const { return Take(calls); }
  std::vector<std::string> TakeQuestions() const { return Take(questions); }
  static std::vector<std::string> Take(const std::string& file) {
    std::vector<std::string> lines;
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    fs::remove(file);
    return lines;
  }
  bool Has(const std::string& name) const { return fs::exists(out + "/" + name); }
};

inline bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace cosplat::test

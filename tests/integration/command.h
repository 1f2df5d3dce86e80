// Runs the built `cosplat`, and makes what its tests work on.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "splat/base/json.h"
#include "splat/media/image_io.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

struct CommandResult {
  int code = 0;  // 128 + signal where it was killed
  std::string out, err;
};

inline std::string Slurp(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  return bytes.str();
}

// `before`: shell commands in front of it, such as limits. program: its path. input: a file that it
// reads on standard input.
inline CommandResult Cosplat(const std::vector<std::string>& arguments,
                             const std::string& before = "",
                             const std::string& program = COSPLAT_COMMAND,
                             const std::string& input = "/dev/null") {
  const TemporaryFolder logs;
  std::string line = before + " '" + program + "'";
  for (const std::string& argument : arguments) line += " '" + argument + "'";
  line += " >'" + (logs / "out") + "' 2>'" + (logs / "err") + "' <'" + input + "'";
  const int status = std::system(line.c_str());
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return {code, Slurp(logs / "out"), Slurp(logs / "err")};
}

// An avatar of the made head, 48 px and 500 Gaussians, hardly trained, in `folder`/out; the head is
// in `folder`/head. Returns what is wrong, or "".
inline std::string MakeSmallAvatar(const TemporaryFolder& folder) {
  const std::string head = folder / "head";
  const CommandResult made = Cosplat(
      {"make-head", "-o", head, "--frames", "6", "--test-frames", "2", "--size", "48", "--quiet"});
  if (made.code != 0) return made.err;
  const CommandResult trained = Cosplat({"train-avatar",
                                         "-s",
                                         head,
                                         "--flame",
                                         head + "/model.npz",
                                         "-m",
                                         folder / "out",
                                         "--iterations",
                                         "4",
                                         "--gaussians",
                                         "500"});
  return trained.code == 0 ? "" : trained.err;
}

// A scene as Blender's exporters write it: a red, a green and a blue ball seen from `views` sides,
// half of them test views.
inline void WriteBallScene(const std::string& folder, int views) {
  constexpr int kSide = 32;
  constexpr double kAngle = 0.7;
  const double focal = kSide / 2.0 / std::tan(kAngle / 2);
  for (const char* split : {"train", "test"}) {
    std::filesystem::create_directories(folder + "/" + split);
    Json frames = Json::array();
    for (int i = 0; i < views; ++i) {
      const double a = 2 * 3.14159265 * (i + (split[1] == 'e' ? 0.5 : 0)) / views;
      const double c = std::cos(a), s = std::sin(a), distance = 4;
      // OpenGL's camera looks along its -z at the origin; y is up.
      frames.push_back(
          {{"file_path", std::string("./") + split + "/r_" + std::to_string(i)},
           {"transform_matrix",
            {{c, 0, s, distance * s}, {0, 1, 0, 0}, {-s, 0, c, distance * c}, {0, 0, 0, 1}}}});
      Image8 image(kSide, kSide, 4);
      double nearest[kSide][kSide] = {};
      for (int ball = 0; ball < 3; ++ball) {
        const double p[3] = {
            0.6 * std::cos(2.1 * ball), 0.3 * ball - 0.3, 0.6 * std::sin(2.1 * ball)};
        const double x = c * p[0] - s * p[2], depth = distance - (s * p[0] + c * p[2]);
        for (int row = 0; row < kSide; ++row)
          for (int column = 0; column < kSide; ++column) {
            const double dx = column + 0.5 - kSide / 2.0 - focal * x / depth;
            const double dy = row + 0.5 - kSide / 2.0 + focal * p[1] / depth;
            if (std::hypot(dx, dy) > 0.35 * focal / depth) continue;
            if (nearest[row][column] > 1 / depth) continue;
            nearest[row][column] = 1 / depth;
            for (int k = 0; k < 3; ++k) image.at(column, row, k) = k == ball ? 220 : 30;
            image.at(column, row, 3) = 255;
          }
      }
      WriteImage(folder + "/" + split + "/r_" + std::to_string(i) + ".png", image);
    }
    std::ofstream(folder + "/transforms_" + split + ".json")
        << Json{{"camera_angle_x", kAngle}, {"frames", frames}};
  }
}

// What the tests share, made once per process: the head's video, an avatar trained on it, a scene
// and its splats.
struct Workshop {
  TemporaryFolder folder;
  std::string head = folder / "head", model = folder / "head/model.npz";
  std::string avatar = folder / "avatar", photos = folder / "photos", scene = folder / "scene";
  std::vector<CommandResult> made;

  Workshop() {
    made.push_back(Cosplat({"make-head",
                            "-o",
                            head,
                            "--frames",
                            "12",
                            "--test-frames",
                            "3",
                            "--size",
                            "64",
                            "--quiet"}));
    made.push_back(Cosplat({"train-avatar",
                            "-s",
                            head,
                            "--flame",
                            model,
                            "-m",
                            avatar,
                            "--iterations",
                            "60",
                            "--gaussians",
                            "1500",
                            "--max-gaussians",
                            "2500",
                            "--eval",
                            "--quiet",
                            "--save_iterations",
                            "30",
                            "60"}));
    WriteBallScene(photos, 6);
    made.push_back(Cosplat({"train-scene",
                            "-s",
                            photos,
                            "-m",
                            scene,
                            "--iterations",
                            "120",
                            "--eval",
                            "--quiet",
                            "--random-points",
                            "600"}));
  }
  static const Workshop& Get() {
    static const Workshop workshop;
    return workshop;
  }
};

// Short trainings of what the workshop made, into folder `out`; `more` arguments follow.
inline std::vector<std::string> MadeSceneTraining(const std::string& out,
                                                  int iterations,
                                                  int points,
                                                  const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"train-scene", "-s", Workshop::Get().photos, "-m", out};
  arguments.insert(arguments.end(), {"--iterations", std::to_string(iterations), "--eval"});
  arguments.insert(arguments.end(), {"--random-points", std::to_string(points)});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}
inline std::vector<std::string> MadeAvatarTraining(const std::string& out,
                                                   int iterations,
                                                   int gaussians,
                                                   const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"train-avatar", "-s", Workshop::Get().head, "-m", out};
  arguments.insert(arguments.end(), {"--flame", Workshop::Get().model, "--eval"});
  arguments.insert(arguments.end(), {"--iterations", std::to_string(iterations)});
  arguments.insert(arguments.end(), {"--gaussians", std::to_string(gaussians)});
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}
inline CommandResult TrainMadeScene(const std::string& out,
                                    int iterations,
                                    int points,
                                    const std::vector<std::string>& more) {
  return Cosplat(MadeSceneTraining(out, iterations, points, more));
}
inline CommandResult TrainMadeAvatar(const std::string& out,
                                     int iterations,
                                     int gaussians,
                                     const std::vector<std::string>& more) {
  return Cosplat(MadeAvatarTraining(out, iterations, gaussians, more));
}

}  // namespace cosplat::test

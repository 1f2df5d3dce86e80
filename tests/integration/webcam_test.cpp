// `cosplat webcam`, with a program that stands in for node, and with Chromium, which sees a film of
// the made head as its camera.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "apps/cosplat/run/latency_film.h"
#include "splat/base/files.h"
#include "tests/integration/command.h"

namespace cosplat {
namespace {

using test::CommandResult;
using test::Cosplat;
using test::TemporaryFolder;

std::vector<Json> LinesOf(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
  return lines;
}

// Programs for PATH.
struct Programs {
  TemporaryFolder folder;
  Programs() {
    MakeDirectories(folder / "bin");
    Write("npm", "mkdir -p node_modules");
    Write("chromium", "exit 0");
  }
  void Write(const std::string& name, const std::string& body) const {
    const std::string path = folder / ("bin/" + name);
    std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }
  CommandResult Run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"webcam"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Cosplat(arguments,
                   "PATH='" + (folder / "bin") + ":/usr/bin:/bin' XDG_CACHE_HOME='" +
                       (folder / "cache") + "'");
  }
};

TEST(Webcam, WritesLinesOfScoresAndTheHead) {
  const Programs programs;
  Json points = Json::array();
  for (int i = 0; i < 478; ++i) points.push_back({100 + i % 30, 100 + i % 17, i % 7});
  std::ofstream lines(programs.folder / "lines");
  for (int i = 0; i < 20; ++i)
    lines << Json{{"camera", "Stand-in"},
                  {"width", 640},
                  {"height", 480},
                  {"time", 1000 + 33 * i},
                  {"milliseconds", 20},
                  {"points", i == 3 ? Json::array() : points}}
          << "\n";
  lines.close();
  programs.Write("node",
                 "cat '" + (programs.folder / "lines") + "'; echo 'it has gone' >&2; exit 1");
  const CommandResult result = programs.Run();
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("Stand-in, 640x480"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("it has gone"), std::string::npos) << result.err;
  const std::vector<Json> frames = LinesOf(result.out);
  ASSERT_EQ(frames.size(), 4u);  // after fifteen with a face
  EXPECT_EQ(frames[0]["seq"], 0);
  EXPECT_NEAR(frames[0]["time"].get<double>(), 1.528, 1e-6);
  EXPECT_EQ(frames[3]["blendshapes"].count("jawOpen"), 1u);
}

TEST(Webcam, NamesWhatIsWrong) {
  const Programs programs;
  programs.Write("node", "exit 3");
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& words) {
    const CommandResult result = programs.Run(arguments);
    EXPECT_EQ(result.code, 2);
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_TRUE(result.out.empty());
  };
  refused({}, "exited with status 3");
  refused({"--camera", "front"}, "--camera: found 'front', expected a number");
  refused({"--camera", "no.y4m"}, "no.y4m: cannot be opened");
  refused({"--to", "udp://127.0.0.1:0"}, "--to");
  programs.Write("node", "echo '{\"camera\": 1}'");
  refused({}, "camera");
}

// Of the same length.
double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sums[5] = {};
  for (size_t i = 0; i < a.size(); ++i) {
    sums[0] += a[i], sums[1] += b[i];
    sums[2] += a[i] * a[i], sums[3] += b[i] * b[i], sums[4] += a[i] * b[i];
  }
  const double n = double(a.size());
  return (n * sums[4] - sums[0] * sums[1]) /
         std::sqrt((n * sums[2] - sums[0] * sums[0]) * (n * sums[3] - sums[1] * sums[1]));
}

// The film begins anywhere, and is repeated, at a frame less each time.
TEST(Webcam, FollowsAFilmOfTheMadeHead) {
  if (std::system("(command -v node && command -v npm && command -v chromium) >/dev/null") != 0)
    GTEST_SKIP() << "node, npm or Chromium is not installed";
  const TemporaryFolder folder;
  constexpr int kFrames = 60;
  const LatencyFilm film = MakeLatencyFilm(folder / "film", kFrames);
  const CommandResult result = Cosplat({"webcam", "--camera", film.path}, "timeout 25");
  if (result.err.find("npm") != std::string::npos) GTEST_SKIP() << result.err;
  // Of its first round, however many of its frames were looked at.
  std::vector<Json> frames;
  const auto passed = [&](const Json& frame) {
    return frame["time"].get<double>() - frames[0]["time"].get<double>();
  };
  for (const Json& frame : LinesOf(result.out))
    if (frames.empty() || 30 * passed(frame) < kFrames) frames.push_back(frame);
  ASSERT_GT(frames.size(), 12u) << result.err;
  double best = -1;
  for (int shift = 0; shift < kFrames; ++shift) {
    std::vector<double> seen, real;
    for (const Json& frame : frames) {
      const size_t at = size_t(std::lround(30 * passed(frame)) + shift) % kFrames;
      seen.push_back(frame["blendshapes"]["jawOpen"]);
      real.push_back(film.frames[at].jaw);
    }
    best = std::max(best, Correlation(seen, real));
  }
  EXPECT_GT(best, 0.9) << "the jaw";
}

TEST(Latency, IsThatOfAFilmInTheCamerasPlace) {
  if (std::system("(command -v node && command -v npm && command -v chromium) >/dev/null") != 0)
    GTEST_SKIP() << "node, npm or Chromium is not installed";
  const TemporaryFolder folder;
  ASSERT_EQ(test::MakeSmallAvatar(folder), "");
  const CommandResult result =
      Cosplat({"latency", folder / "out", "--seconds", "6", "--size", "64x64"});
  if (result.err.find("npm") != std::string::npos) GTEST_SKIP() << result.err;
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("camera to picture"), std::string::npos) << result.out;
  std::istringstream jaw(result.out.substr(std::min(result.out.find("\njaw "), result.out.size())));
  std::string name;
  double lag = 0, r = 0;
  jaw >> name >> lag >> r;
  EXPECT_GT(r, 0.8) << result.out;
}

TEST(Latency, IsOfAvatars) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a.ply") << "ply\n";
  const CommandResult result = Cosplat({"latency", folder / "a.ply"});
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("a.ply"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace cosplat

// `cosplat serve` and `cosplat export --html`: what they refuse, and the page's content. What the
// pages show is tested in a browser (tests/web).
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>

#include "splat/base/files.h"
#include "splat/io/ply.h"
#include "tests/integration/command.h"

namespace cosplat {
namespace {

using test::CommandResult;
using test::Cosplat;
using test::TemporaryFolder;

std::string WriteScene(const TemporaryFolder& folder) {
  Gaussians g;
  g.basis = Basis::kSh;
  g.Resize(8);
  for (size_t i = 0; i < 8; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      g.at(kPosition, i)[k] = float(i >> k & 1);
      g.at(kScaleLog, i)[k] = -2;
    }
    g.at(kRotation, i)[0] = 1;
    *g.at(kOpacityLogit, i) = 3;
  }
  WritePly(folder / "<!--.ply", g);
  return folder / "<!--.ply";
}

void ExpectRefused(const std::vector<std::string>& arguments, const std::string& part) {
  const CommandResult result = Cosplat(arguments);
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  EXPECT_EQ(result.out, "");
}

TEST(WebCommands, BadInputIsNamed) {
  const TemporaryFolder folder;
  const std::string page = folder / "page.html";
  ExpectRefused({"serve", folder / "none.ply"}, "none.ply");
  ExpectRefused({"serve", folder / "none.glb", "--flame", "f.npz"}, "none.glb");
  ExpectRefused({"serve", "x.ply", "--page", "cinema"}, "--page");
  ExpectRefused({"serve", "x.ply", "--port", "70000"}, "--port");
  ExpectRefused({"serve"}, "model: is missing; only --page studio has none");
  ExpectRefused({"serve", "x.ply", "--page", "studio"}, "--page studio");
  ExpectRefused({"export", "--splats", folder / "none.ply", "--html", page}, "none.ply");
  const std::string packed = folder / "scene.sog";
  const CommandResult written =
      Cosplat({"export", "--splats", WriteScene(folder), "--sog", packed});
  ASSERT_EQ(written.code, 0) << written.err;
  ExpectRefused({"export", "--splats", packed, "--html", page}, "SOG");
  EXPECT_FALSE(std::filesystem::exists(page));
}

// Without the player, which is built separately, both name the command that builds it.
TEST(WebCommands, PageHoldsTheModelOrNamesWhatIsMissing) {
  const TemporaryFolder folder;
  const std::string scene = WriteScene(folder), page = folder / "page.html";
  const CommandResult result = Cosplat({"export", "--splats", scene, "--html", page});
  if (result.code == 2) {
    EXPECT_NE(result.err.find("offline.html: is missing: `./run web`"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(page));
    GTEST_SKIP() << "the browser's player is not built";
  }
  ASSERT_EQ(result.code, 0) << result.err;
  const std::vector<char> bytes = ReadFile(page);
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_EQ(text.find("@MODEL@"), std::string::npos);
  EXPECT_NE(text.find("\"splats\":{\"base64\":\"cGx5C"), std::string::npos);  // "ply\n"
  EXPECT_NE(text.find("\\u003c!--.ply"), std::string::npos);  // a name cannot end the script
}

TEST(WebCommands, PortsInUseAreRefused) {
  const TemporaryFolder folder;
  const std::string scene = WriteScene(folder);
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  const std::string port = std::to_string(ntohs(address.sin_port));
  const CommandResult result = Cosplat({"serve", scene, "--no-open", "--port", port});
  close(listener);
  EXPECT_EQ(result.code, 2);
  if (result.err.find("./run web") != std::string::npos) GTEST_SKIP() << "no player is built";
  EXPECT_NE(result.err.find("--port: " + port + " is in use"), std::string::npos) << result.err;
}

}  // namespace
}  // namespace cosplat

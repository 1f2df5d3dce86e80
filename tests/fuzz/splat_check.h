// What must hold of a reader of splat files whatever it is given: checked by the mutation tests and
// by the fuzzer.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/zip_reader.h"
#include "splat/base/zip_writer.h"
#include "splat/io/ply.h"
#include "splat/io/significance.h"
#include "splat/io/sog.h"
#include "splat/io/splat_file.h"
#include "splat/io/spz.h"
#include "tests/support/random_gaussians.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {

// Reads `bytes` as a splat file under this name; what is wrong with what came of it, or "".
inline std::string SplatProblem(const std::string& path, const std::string& bytes, bool& good) {
  WriteFileAtomically(path, bytes);
  try {
    const Gaussians g = ReadSplats(path);
    good = true;
    for (const auto& values : g.values)
      for (const float x : values)
        if (!std::isfinite(x)) return "a number that is not finite";
    return g.size() > bytes.size() && g.size() > (1 << 16) ? "more splats than bytes" : "";
  } catch (const Error& error) {
    const std::string text = error.what();
    if (text.find('\n') != std::string::npos) return "an error of two lines: " + text;
    return text.size() > 600 ? "an error without an end" : "";
  }
}

// Good files of each layout, of a few Gaussians.
struct SplatSeeds {
  SplatSeeds() {
    const TemporaryFolder folder;
    const Gaussians g = RandomGaussians(30, 1, Basis::kSh, 1);
    const auto text = [&](const std::string& name) {
      const std::vector<char> bytes = ReadFile(folder / name);
      return std::string(bytes.begin(), bytes.end());
    };
    WriteSpz(folder / "3.spz", g, {}, 3);
    spz3 = text("3.spz");
    const std::vector<char> packed(spz3.begin(), spz3.end());
    const auto plain = GunzipReader("3.spz", packed).Read("all", 16 + 30 * 29);
    spz3_plain.assign(plain.begin(), plain.end());
    WriteSpz(folder / "4.spz", g, {}, 4);
    spz4 = text("4.spz");
    WriteSog(folder / "a.sog", g, SizeSignificance(g), {});
    sog = text("a.sog");
    const ZipReader zip(folder / "a.sog", "SOG");
    for (size_t i = 0; i < zip.size(); ++i) {
      const std::vector<char> member = zip.Read(i);
      members_.push_back({zip.Name(i), {member.begin(), member.end()}, false});
    }
    sog_meta = members_.at(0).bytes;
    WriteSceneGlb(folder / "a.glb", g);
    glb = text("a.glb");
    WritePly(folder / "a.ply", g);
    ply = text("a.ply");
    for (int i = 0; i < 8; ++i) {
      const float numbers[6] = {float(i), 1, -2, 0.1f, 0.2f, 0.3f};
      records.append(reinterpret_cast<const char*>(numbers), sizeof(numbers));
      records += "\x10\x80\xf0\xc0\xff\x80\x60\x90";
    }
  }
  // The bundle's bytes with another meta.json; `path` is where it is written on the way.
  std::string SogWithMeta(const std::string& meta, const std::string& path) const {
    std::vector<ZipMember> members = members_;
    members.at(0).bytes = meta;
    WriteZip(path, members);
    const std::vector<char> bytes = ReadFile(path);
    return {bytes.begin(), bytes.end()};
  }

  std::string spz3, spz3_plain, spz4, sog, sog_meta, glb, ply, records;

 private:
  std::vector<ZipMember> members_;
};

}  // namespace cosplat::test

// Readers of what comes from outside, as the mutation tests and libFuzzer's harness drive them.
//
// A reader gets bytes, places them where the program would find them, and reads them. Whatever they
// are, it returns or throws Error of one line, and what it returns is sane.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "splat/base/npz.h"

namespace cosplat::test {

// What becomes of an input on its way to the reader. Where there are several parts, kPartMark is
// between them.
enum class Placing {
  kFiles,       // part i becomes the file files[i]; files without a part are absent
  kZip,         // name, bytes, name, bytes, ...: files[0] is a ZIP archive of these members
  kGzip,        // files[0] is the input compressed
  kGlb,         // JSON, binary: files[0] is a .glb with these chunks
  kChecksummed  // files[0] is the input with the CRC-32 of all but its last four bytes in these
};

extern const char* const kPartMark;

struct FuzzedReader {
  std::string name;
  Placing placing = Placing::kFiles;
  std::vector<std::string> files;  // below the folder
  // Reads them; returns what is wrong with what was read, or "". `bytes`: the input as it is.
  std::function<std::string(const std::string& folder, const std::string& bytes)> read;
  // Inputs that are accepted, made by the program's writers where it has some.
  std::function<std::vector<std::string>()> seeds;
  std::vector<std::string> words;  // that the format has, for dictionaries
  // Files that do not change, written once; or null.
  std::function<void(const std::string& folder)> prepare = nullptr;
};

inline std::ostream& operator<<(std::ostream& out, const FuzzedReader& reader) {
  return out << reader.name;
}

const std::vector<FuzzedReader>& FuzzedReaders();

// Their parts, each in a file of its own.
std::vector<FuzzedReader> SplatReaders();  // of Gaussians
std::vector<FuzzedReader> HeadReaders();   // of FLAME, tracks and avatars
std::vector<FuzzedReader> LiveReaders();   // of live faces
std::vector<FuzzedReader> RunReaders();    // of scenes, settings and checkpoints

// Inputs of several parts, and the parts of one.
std::string JoinParts(const std::vector<std::string>& parts);
std::vector<std::string> SplitParts(const std::string& bytes);

// The members of a ZIP archive as an input for Placing::kZip.
std::string PartsOfZip(const std::string& path);
std::string Slurped(const std::string& path);

// Of an archive of arrays: the input for Placing::kZip, and what a dictionary has.
std::vector<std::string> NpzSeeds(const Npz& npz);
std::vector<std::string> NpyWords();

// Whether a number is finite, of anything that can be iterated over.
template <class Numbers>
std::string NotFinite(const Numbers& numbers) {
  for (const auto x : numbers)
    if (!(x - x == 0)) return "a number that is not finite";
  return "";
}

class ReaderRun {
 public:
  // `folder` exists and belongs to this object from now on.
  ReaderRun(const FuzzedReader& reader, std::string folder);
  // Reads `bytes`; what is wrong with what came of it, or "". `good`: they were accepted.
  std::string Problem(const std::string& bytes, bool& good);
  // Of the last input that was refused.
  const std::string& refusal() const { return refusal_; }

 private:
  void Place(const std::string& bytes) const;

  const FuzzedReader& reader_;
  std::string folder_, refusal_;
};

}  // namespace cosplat::test

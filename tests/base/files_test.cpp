#include "splat/base/files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "splat/base/skipped.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

size_t FileCount(const std::string& folder) {
  const std::filesystem::directory_iterator begin(folder);
  return size_t(std::distance(begin, std::filesystem::directory_iterator()));
}

std::string TextOf(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return {bytes.begin(), bytes.end()};
}

TEST(Files, WritesAndReadsBack) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a.txt", "one\ntwo");
  EXPECT_EQ(TextOf(folder / "a.txt"), "one\ntwo");
  WriteFileAtomically(folder / "a.txt", "");
  EXPECT_EQ(TextOf(folder / "a.txt"), "");
  EXPECT_EQ(FileCount(folder.path()), 1u);
}

TEST(Files, WritesDurably) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a.bin", "old");
  WriteFileDurably(folder / "a.bin", [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(TextOf(folder / "a.bin"), "new");
  EXPECT_EQ(FileCount(folder.path()), 1u);
  ExpectError([&] { WriteFileDurably(folder / "none/a.bin", [](std::ostream&) {}); },
              {"none/a.bin", "No such file"});
}

TEST(Files, RemovesTemporariesOfProcessesThatAreGone) {
  const TemporaryFolder folder;
  // No process has the largest number; this one has its own.
  const std::string gone = ".tmp.2147483647", own = ".tmp." + std::to_string(getpid());
  for (const std::string& name : {"a.ply" + gone,
                                  "b" + gone + ".npz",
                                  "c/d.png" + gone,
                                  "a.ply" + own,
                                  std::string("e.tmp.x"),
                                  std::string("f.tmp.")}) {
    MakeDirectories(folder / "c");
    WriteFileAtomically(folder / name, "");
  }
  RemoveTemporaries(folder.path());
  EXPECT_EQ(FileCount(folder.path()), 4u);  // the folder c is one of them
  EXPECT_EQ(FileCount(folder / "c"), 0u);
  RemoveTemporaries(folder / "none");
  RemoveFile(folder / "e.tmp.x");
  RemoveFile(folder / "e.tmp.x");
  EXPECT_EQ(FileCount(folder.path()), 3u);
  ExpectError([&] { RemoveFile(folder.path()); }, {folder.path(), "cannot be removed"});
}

TEST(Files, Crc32) {
  EXPECT_EQ(Crc32("123456789", 9), 0xcbf43926u);  // the value that is given for it everywhere
  EXPECT_EQ(Crc32("6789", 4, Crc32("12345", 5)), 0xcbf43926u);
  EXPECT_EQ(Crc32(nullptr, 0, 7), 7u);
}

TEST(Files, AFailedWriteLeavesTheOldFileAndNoTemporary) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a.txt", "old");
  const auto fail_half_way = [&] {
    WriteFileAtomically(folder / "a.txt", [](std::ostream& out) {
      out << "half";
      throw Error("a.txt", "", "stopped");
    });
  };
  ExpectError(fail_half_way, {"stopped"});
  const auto fail_in_own_writer = [&] {
    WriteViaTemporary(folder / "a.txt", [](const std::string& temporary) {
      WriteFileAtomically(temporary, "half");
      throw Error("a.txt", "", "stopped");
    });
  };
  ExpectError(fail_in_own_writer, {"stopped"});
  EXPECT_EQ(TextOf(folder / "a.txt"), "old");
  EXPECT_EQ(FileCount(folder.path()), 1u);
}

TEST(Files, AFullDiskIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
  ExpectError([] { WriteFileAtomically("/dev/full", std::string(100000, 'x')); },
              {"/dev/full", "write failed", "No space left"});
  EXPECT_FALSE(std::filesystem::is_regular_file("/dev/full"));
}

TEST(Files, NamesWhatCannotBeReadOrWritten) {
  const TemporaryFolder folder;
  ExpectError([&] { ReadFile(folder / "none"); }, {"none", "No such file"});
  ExpectError([&] { ReadFile(folder.path()); }, {folder.path(), "is a folder"});
  ExpectError([&] { WriteFileAtomically(folder / "no/a.txt", "x"); }, {"no/a.txt", "No such file"});
  WriteFileAtomically(folder / "file", "x");
  ExpectError([&] { MakeDirectories(folder / "file/below"); }, {"file/below"});
  ExpectError([&] { MakeDirectories(folder / "file"); }, {"file"});
  MakeDirectories(folder / "a/b/c");
  MakeDirectories(folder / "a/b/c");
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b/c"));
}

TEST(Files, TemporaryNamesKeepFolderAndExtension) {
  const std::filesystem::path temporary(TemporaryPath("/some/where/x.glb"));
  EXPECT_EQ(temporary.parent_path(), "/some/where");
  EXPECT_EQ(temporary.extension(), ".glb");
  EXPECT_NE(temporary.filename(), "x.glb");
}

// Digests from FIPS 180-4's examples and, for the lengths around a block's end, from sha256sum.
TEST(Sha256, KnownDigests) {
  EXPECT_EQ(Sha256("", 0), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256("abc", 3), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const std::string two_blocks = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";
  EXPECT_EQ(Sha256(two_blocks.data(), two_blocks.size()),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  // Lengths at which the padding takes another block.
  const std::string a(64, 'a');
  EXPECT_EQ(Sha256(a.data(), 55),
            "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318");
  EXPECT_EQ(Sha256(a.data(), 56),
            "b35439a4ac6f0948b6d6f9e3c6af0f5f590ce20f1bde7090ef7970686ec6738a");
  EXPECT_EQ(Sha256(a.data(), 64),
            "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb");
  const std::string million(1000000, 'a');
  EXPECT_EQ(Sha256(million.data(), million.size()),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a", "abc");
  EXPECT_EQ(Sha256OfFile(folder / "a"), Sha256("abc", 3));
}

TEST(Skipped, AThirdMayBeMissing) {
  const SkippedFrame bad{"7.png", "is missing"};
  EXPECT_NO_THROW(CheckSkipped("set", 2, {bad}));
  EXPECT_NO_THROW(CheckSkipped("set", 1, {}));
  ExpectError([&] { CheckSkipped("set", 1, {bad}); }, {"set", "1 of 2", "7.png: is missing"});
  ExpectError([&] { CheckSkipped("set", 5, {bad, bad, bad, bad}); }, {"4 of 9", "..."});
  ExpectError([&] { CheckSkipped("set", 0, {}); }, {"set", "contains no frames"});
  ExpectError([&] { CheckSkipped("set", 0, {bad}); }, {"1 of 1"});
}

}  // namespace
}  // namespace cosplat

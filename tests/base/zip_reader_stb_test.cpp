// splat/base/zip_reader_stb.cpp on archives that libzip wrote, and on damaged ones.
#include <gtest/gtest.h>

#include <filesystem>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "splat/base/zip_archive.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

// Compressible, with a member of every kind of end: deflate's last bits are anywhere in a byte.
std::string WriteArchive(const TemporaryFolder& folder) {
  Npz npz;
  for (int k = 1; k < 40; ++k) {
    std::vector<float> values(size_t(100 * k));
    for (size_t i = 0; i < values.size(); ++i) values[i] = float(i * i % size_t(7 * k));
    npz.Add("array_" + std::to_string(k), {values.size()}, values);
  }
  const std::string path = folder.path() + "/a.npz";
  npz.Write(path);
  return path;
}

TEST(ZipReaderStb, InflatesEveryMember) {
  const TemporaryFolder folder;
  const std::string path = WriteArchive(folder);
  EXPECT_LT(std::filesystem::file_size(path), 100000u);  // of 312 kB: they are compressed
  const Npz npz = Npz::Read(path);
  for (int k = 1; k < 40; ++k) {
    const NpyArray& array = npz.Get("array_" + std::to_string(k), {100 * k});
    for (size_t i = 0; i < array.size(); ++i)
      ASSERT_EQ(array.values[i], double(i * i % size_t(7 * k)));
  }
  const ZipReader archive(path, ".npz");
  const size_t index = archive.Find("array_39.npy");
  ASSERT_LT(index, archive.size());
  EXPECT_EQ(archive.Find("nothing"), archive.size());
  ExpectError([&] { archive.Read(index, 100); }, {"a.npz", "array_39.npy", "at most 100"});
}

// Whatever byte is changed or however much is cut off: the same bytes, or an error.
TEST(ZipReaderStb, DamageIsNeverTakenForData) {
  const TemporaryFolder folder;
  const std::string path = WriteArchive(folder);
  const std::vector<char> good = ReadFile(path);
  std::vector<std::vector<char>> contents;
  {
    const ZipReader archive(path, ".npz");
    for (size_t i = 0; i < archive.size(); ++i) contents.push_back(archive.Read(i));
  }
  const auto check = [&](const std::vector<char>& bytes) {
    WriteFileAtomically(path, std::string(bytes.begin(), bytes.end()));
    try {
      const ZipReader archive(path, ".npz");
      for (size_t i = 0; i < archive.size(); ++i) {
        const std::vector<char> read = archive.Read(i);
        EXPECT_TRUE(i < contents.size() && read == contents[i]);
      }
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("a.npz"), std::string::npos);
    }
  };
  for (size_t k = 0; k < good.size(); k += 97) {
    std::vector<char> bad = good;
    bad[k] = char(bad[k] ^ 0x55);
    check(bad);
    check({good.begin(), good.begin() + long(k)});
  }
}

}  // namespace
}  // namespace cosplat

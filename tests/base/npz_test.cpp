#include "splat/base/npz.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "splat/base/files.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

using test::ExpectError;
using test::TemporaryFolder;

// A format 1.0 array as NumPy writes it.
std::vector<char> Npy(const std::string& descr,
                      bool fortran,
                      const std::string& shape,
                      const std::string& data) {
  std::string header = "{'descr': " + descr + ", 'fortran_order': " + (fortran ? "True" : "False") +
                       ", 'shape': " + shape + ", }\n";
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += char(header.size());
  bytes += '\0';
  bytes += header + data;
  return {bytes.begin(), bytes.end()};
}

template <class T>
std::string Raw(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

NpyArray Parse(const std::vector<char>& bytes) {
  NpyArray array;
  EXPECT_TRUE(ParseNpy("f.npz", "a.npy", bytes, array));
  return array;
}

TEST(Npy, ReadsEveryKindOfNumber) {
  const std::vector<double> expected{1, 2, 100};
  EXPECT_EQ(Parse(Npy("'<f4'", false, "(3,)", Raw<float>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'<f8'", false, "(3,)", Raw<double>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'|i1'", false, "(3,)", Raw<int8_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'|u1'", false, "(3,)", Raw<uint8_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'<i2'", false, "(3,)", Raw<int16_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'<u2'", false, "(3,)", Raw<uint16_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'<i4'", false, "(3,)", Raw<int32_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'<u4'", false, "(3,)", Raw<uint32_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'<i8'", false, "(3,)", Raw<int64_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'<u8'", false, "(3,)", Raw<uint64_t>({1, 2, 100}))).values, expected);
  EXPECT_EQ(Parse(Npy("'|b1'", false, "(2,)", std::string("\1\0", 2))).values,
            (std::vector<double>{1, 0}));
}

TEST(Npy, ReadsHalves) {
  // 1, -2, 65504 (greatest), 2^-14 (least normal), 2^-24 (least), 0.333 rounded, inf, nan.
  const std::vector<uint16_t> bits{0x3c00, 0xc000, 0x7bff, 0x0400, 0x0001, 0x3555, 0x7c00, 0x7e00};
  const NpyArray array = Parse(Npy("'<f2'", false, "(8,)", Raw(bits)));
  const std::vector<double> expected{
      1, -2, 65504, std::ldexp(1, -14), std::ldexp(1, -24), 0.333251953125};
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(array.values[i], expected[i]);
  EXPECT_TRUE(std::isinf(array.values[6]));
  EXPECT_TRUE(std::isnan(array.values[7]));
}

TEST(Npy, FortranOrderIsTurnedToC) {
  // [[0, 1, 2], [3, 4, 5]] stored by columns, and the same as [2, 3, 1].
  const std::string data = Raw<float>({0, 3, 1, 4, 2, 5});
  const std::vector<double> expected{0, 1, 2, 3, 4, 5};
  EXPECT_EQ(Parse(Npy("'<f4'", true, "(2, 3)", data)).values, expected);
  EXPECT_EQ(Parse(Npy("'<f4'", true, "(2, 3, 1)", data)).values, expected);
}

TEST(Npy, ReadsScalarsAndEmptyArrays) {
  const NpyArray scalar = Parse(Npy("'<f8'", false, "()", Raw<double>({7})));
  EXPECT_TRUE(scalar.shape.empty());
  EXPECT_EQ(scalar.values, std::vector<double>{7});
  EXPECT_EQ(Parse(Npy("'<f8'", false, "(0, 5)", "")).size(), 0u);
}

TEST(Npy, RefusesWhatItCannotRead) {
  NpyArray array;
  const auto expect = [&](const std::vector<char>& bytes, const std::string& part) {
    ExpectError([&] { ParseNpy("f.npz", "a.npy", bytes, array); }, {"f.npz", "a.npy", part});
  };
  expect(Npy("'|O'", false, "(1,)", "12345678"), "|O");
  expect(Npy("'>f4'", false, "(1,)", "1234"), "little-endian");
  expect(Npy("[('x', '<f4')]", false, "(1,)", "1234"), "structured dtype");
  expect(Npy("'<f4'", false, "(2,)", "1234"), "4 bytes of data, its shape needs 8");
  expect(Npy("'<f4'", false, "(99999999999, 99999999999)", "1234"), "too large shape");
  expect({'x'}, "not a .npy");
  EXPECT_FALSE(ParseNpy("f.npz", "a.npy", Npy("'<U3'", false, "(1,)", "123456789012"), array));
  const std::vector<char> whole = Npy("'<f4'", false, "(2,)", Raw<float>({1, 2}));
  for (size_t cut = 0; cut < whole.size(); ++cut) {
    const std::vector<char> part(whole.begin(), whole.begin() + long(cut));
    EXPECT_THROW(ParseNpy("f.npz", "a.npy", part, array), Error) << cut;
  }
}

TEST(Npz, WritesWhatItReads) {
  const TemporaryFolder folder;
  Npz npz;
  npz.Add("floats", {2, 3}, std::vector<float>{0, 1.5f, -2, 3e-20f, 4, 5});
  npz.Add("scalar", {}, std::vector<float>{2});
  npz.Add("integers", {2}, std::vector<int32_t>{-7, 2000000001});
  npz.Write(folder / "a.npz");
  const Npz read = Npz::Read(folder / "a.npz");
  EXPECT_EQ(read.arrays().size(), 3u);
  EXPECT_EQ(read.Get("floats", {2, 3}).values, npz.Get("floats").values);
  EXPECT_EQ(read.Get("floats", {-1, 3}).dtype, "<f4");
  EXPECT_EQ(read.Get("integers").values, (std::vector<double>{-7, 2000000001}));
  EXPECT_EQ(read.Get("scalar").values, std::vector<double>{2});
  read.Write(folder / "b.npz");
  EXPECT_EQ(ReadFile(folder / "a.npz"), ReadFile(folder / "b.npz"));
  ExpectError([&] { read.Get("none"); }, {"a.npz", "none", "missing"});
  ExpectError([&] { read.Get("floats", {3, -1}); }, {"a.npz", "floats", "[2, 3]", "[3, *]"});
  ExpectError([&] { npz.Add("bad", {3}, std::vector<float>{1}); }, {"bad", "1 values", "needs 3"});
}

TEST(Npz, DamagedFilesAreErrors) {
  const TemporaryFolder folder;
  Npz npz;
  std::vector<float> values(500);
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(std::sin(double(i)));
  npz.Add("a", {500}, values);
  npz.Write(folder / "a.npz");
  const std::vector<char> whole = ReadFile(folder / "a.npz");
  for (size_t cut : {size_t(0), size_t(10), whole.size() / 2, whole.size() - 1}) {
    WriteFileAtomically(folder / "cut.npz", std::string(whole.begin(), whole.begin() + long(cut)));
    ExpectError([&] { Npz::Read(folder / "cut.npz"); }, {"cut.npz"});
  }
  std::string flipped(whole.begin(), whole.end());
  flipped[flipped.size() / 2] ^= 0x10;
  WriteFileAtomically(folder / "flipped.npz", flipped);
  ExpectError([&] { Npz::Read(folder / "flipped.npz"); }, {"flipped.npz", "a.npy"});
  ExpectError([&] { Npz::Read(folder / "none.npz"); }, {"none.npz", "No such file"});
  ExpectError([&] { npz.Write(folder / "no/a.npz"); }, {"no/a.npz"});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3);
}

// Two members that would unpack to 1.5 GiB each, in a file of some 300 bytes.
TEST(Npz, RefusesWhatUnpacksWithoutEnd) {
  const TemporaryFolder folder;
  Npz npz(folder / "a.npz");
  npz.Add("a", {1}, std::vector<float>{1});
  npz.Add("b", {1}, std::vector<float>{1});
  npz.Write(npz.path());
  std::vector<char> bytes = ReadFile(npz.path());
  const std::string mark = "PK\1\2";
  const uint32_t size = 3u << 29;
  int members = 0;
  for (auto at = bytes.begin();
       (at = std::search(at, bytes.end(), mark.begin(), mark.end())) != bytes.end();
       at += 4, ++members)
    std::memcpy(&at[24], &size, sizeof size);
  ASSERT_EQ(members, 2);
  WriteFileAtomically(npz.path(), std::string(bytes.begin(), bytes.end()));
  ExpectError([&] { Npz::Read(npz.path()); }, {"a.npz", "b.npy", "2 GiB"});
}

}  // namespace
}  // namespace cosplat

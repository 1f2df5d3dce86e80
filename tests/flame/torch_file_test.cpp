// ReadTorchFile: what torch.save writes is read as data; damage and hostile content give
// one line.
#include <gtest/gtest.h>

#include <cmath>

#include "flame/io/pickle.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/rng.h"
#include "tests/flame/pickle_builder.h"
#include "tests/fuzz/mutate.h"
#include "tests/support/expect_error.h"
#include "tests/support/stored_zip.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

using namespace pickle;  // NOLINT: a vocabulary

using Members = std::vector<std::pair<std::string, std::string>>;

const std::string kSixFloats = Raw(std::vector<float>{1, 2, 3, 4, 5, 6});

// An archive of torch's whose root is `value`, with storage "0".
Members ArchiveOf(const std::string& value, const std::string& storage = kSixFloats) {
  return {{"00000/data.pkl", File(value)},
          {"00000/byteorder", "little"},
          {"00000/data/0", storage},
          {"00000/version", "3\n"}};
}

class TorchFile : public ::testing::Test {
 protected:
  void Write(const Members& members) { WriteFileAtomically(path_, StoredZip(members)); }
  NpyArray ArrayIn(const Members& members) {
    Write(members);
    const Pickle pickle = ReadTorchFile(path_);
    return ArrayOf(path_, "array", pickle.root());
  }
  void ExpectRefused(const Members& members, std::vector<std::string> words) {
    words.push_back("a.frame");
    ExpectError([&] { ArrayIn(members); }, words);
  }

  TemporaryFolder folder_;
  const std::string path_ = folder_ / "a.frame";
};

TEST_F(TorchFile, HoldsNumpyArraysOrTensors) {
  const std::vector<double> expected{1, 2, 3, 4, 5, 6};
  const NpyArray numpy = ArrayIn(ArchiveOf(Floats({2, 3}, {1, 2, 3, 4, 5, 6})));
  EXPECT_EQ(numpy.values, expected);
  const std::string storage = Storage("FloatStorage", "0", 6);
  const NpyArray tensor = ArrayIn(ArchiveOf(Tensor(storage, 0, {2, 3}, {3, 1})));
  EXPECT_EQ(tensor.shape, (std::vector<size_t>{2, 3}));
  EXPECT_EQ(tensor.values, expected);
  // A transposed view, a row of a larger tensor, an expanded one, a parameter, a scalar.
  EXPECT_EQ(ArrayIn(ArchiveOf(Tensor(storage, 0, {3, 2}, {1, 3}))).values,
            (std::vector<double>{1, 4, 2, 5, 3, 6}));
  EXPECT_EQ(ArrayIn(ArchiveOf(Tensor(storage, 3, {1, 3}, {3, 1}))).values,
            (std::vector<double>{4, 5, 6}));
  EXPECT_EQ(ArrayIn(ArchiveOf(Tensor(storage, 1, {3}, {0}))).values,
            (std::vector<double>{2, 2, 2}));
  EXPECT_EQ(ArrayIn(ArchiveOf(Reduce(Class("torch._utils", "_rebuild_parameter"),
                                     Tuple({Tensor(storage, 0, {6}, {1}), "\x88", "}"}))))
                .values,
            expected);
  EXPECT_EQ(ArrayIn(ArchiveOf(Tensor(storage, 5, {}, {}))).values, (std::vector<double>{6}));
  // Other types, and members without a folder.
  EXPECT_EQ(ArrayIn({{"data.pkl", File(Tensor(Storage("LongStorage", "0", 2), 0, {2}, {1}))},
                     {"data/0", Raw(std::vector<int64_t>{-7, 1LL << 40})}})
                .values,
            (std::vector<double>{-7, double(1LL << 40)}));
  EXPECT_EQ(ArrayIn(ArchiveOf(Tensor(Storage("HalfStorage", "0", 1), 0, {1}, {1}),
                              std::string("\x00\x3e", 2)))
                .values,
            (std::vector<double>{1.5}));
}

TEST_F(TorchFile, TensorsThatShareAStorageReadItOnce) {
  const std::string storage = Storage("FloatStorage", "0", 6);
  Write(
      ArchiveOf(Dict({{"a", Tensor(storage, 0, {2}, {1})}, {"b", Tensor(storage, 4, {2}, {1})}})));
  const Pickle pickle = ReadTorchFile(path_);
  const PickleValue *a = pickle.root().Find("a"), *b = pickle.root().Find("b");
  EXPECT_EQ(a->items[0], b->items[0]);
  EXPECT_EQ(ArrayOf(path_, "b", *b).values, (std::vector<double>{5, 6}));
}

TEST_F(TorchFile, DamageGivesOneLine) {
  const std::string storage = Storage("FloatStorage", "0", 6);
  const std::string good = Tensor(storage, 0, {2, 3}, {3, 1});
  ExpectRefused(ArchiveOf(Tensor(storage, 1, {2, 3}, {3, 1})), {"beyond its storage of 6"});
  ExpectRefused(ArchiveOf(Tensor(storage, -1, {1}, {1})), {"beyond its storage"});
  ExpectRefused(ArchiveOf(Tensor(storage, 5, {2}, {-9})), {"beyond its storage"});
  ExpectRefused(ArchiveOf(Tensor(storage, 0, {2, 3}, {1})), {"other strides"});
  ExpectRefused(ArchiveOf(Tensor(storage, 0, {1 << 20, 1 << 20}, {0, 0})), {"too large shape"});
  ExpectRefused(ArchiveOf(Tensor(storage, 0, {0}, {1})), {"shape"});
  ExpectRefused(ArchiveOf(Tensor(Text("no storage"), 0, {1}, {1})), {"unknown form"});
  ExpectRefused(ArchiveOf(good, kSixFloats.substr(0, 22)), {"holds 22 bytes"});
  ExpectRefused(ArchiveOf(Tensor(Storage("FloatStorage", "7", 6), 0, {1}, {1})),
                {"00000/data/7", "is missing"});
  ExpectRefused(ArchiveOf(Tensor(Storage("FloatStorage", "../../etc/passwd", 6), 0, {1}, {1})),
                {"00000/data/../../etc/passwd", "is missing"});
  ExpectRefused(ArchiveOf(Tensor(Storage("UntypedStorage", "0", 6), 0, {1}, {1})),
                {"data.pkl", "byte", "class torch.UntypedStorage is not accepted"});
  ExpectRefused(ArchiveOf(Tuple({Text("storage")}) + "Q"), {"no storage of torch's"});
  ExpectRefused(ArchiveOf(Reduce(Class("os", "system"), Tuple({Text("true")}))),
                {"data.pkl", "class os.system is not accepted"});
  ExpectRefused({{"00000/version", "3"}}, {"data.pkl", "is missing", "torch.save"});
  Members big = ArchiveOf(good);
  big[1].second = "big";
  ExpectRefused(big, {"byteorder", "not little"});
  // The file is cut, is no archive, or its checksum is wrong.
  const std::string bytes = StoredZip(ArchiveOf(good));
  for (const std::string& damaged :
       {bytes.substr(0, bytes.size() - 9), bytes.substr(0, 40), std::string("\x80\x02}.")}) {
    WriteFileAtomically(path_, damaged);
    ExpectError([&] { ReadTorchFile(path_); }, {"a.frame", "torch.save"});
  }
  WriteFileAtomically(path_, std::string());
  ExpectError([&] { ReadTorchFile(path_); }, {"a.frame", "is empty"});
  std::string flipped = bytes;
  flipped[flipped.find("storage") + 1] ^= 1;
  WriteFileAtomically(path_, flipped);
  ExpectError([&] { ReadTorchFile(path_); }, {"a.frame", "00000/data.pkl", "is damaged"});
  ExpectError([&] { ReadTorchFile(folder_ / "none.frame"); }, {"none.frame"});
}

// Whatever the bytes are, an array of finite size or one line comes out.
TEST_F(TorchFile, SurvivesMutation) {
  const std::string storage = Storage("FloatStorage", "0", 6);
  const std::vector<std::string> seeds = {
      File(Dict({{"a", Tensor(storage, 0, {2, 3}, {3, 1})}, {"b", Floats({2}, {1, 2})}})),
      File(Dict({{"a",
                  Reduce(Class("torch._utils", "_rebuild_parameter"),
                         Tuple({Tensor(storage, 0, {6}, {1}), "\x88", "}"}))}}))};
  Rng rng{7};
  int read = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Members members = ArchiveOf("N");
    members[0].second = Mutated(seeds[size_t(i) % seeds.size()], seeds, rng);
    // Every other one is broken as an archive.
    std::string bytes = StoredZip(members);
    if (i % 2) bytes = Mutated(bytes, {bytes}, rng);
    WriteFileAtomically(path_, bytes);
    try {
      const Pickle pickle = ReadTorchFile(path_);
      for (const char* key : {"a", "b"})
        if (const PickleValue* value = pickle.root().Find(key)) ArrayOf(path_, key, *value);
      ++read;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find(path_), 0u) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(read, 10);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace cosplat::test

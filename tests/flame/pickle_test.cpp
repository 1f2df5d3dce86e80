// flame/io/pickle.h and pickle_arrays.h: what CPython writes is read; what could do harm is
// refused.
#include "flame/io/pickle.h"

#include <gtest/gtest.h>

#include "splat/base/error.h"
#include "tests/flame/pickle_builder.h"

namespace cosplat::test {
namespace {

using Kind = PickleValue::Kind;
using namespace pickle;  // NOLINT: a vocabulary

std::vector<char> ToBytes(const std::string& s) { return {s.begin(), s.end()}; }

std::string FromHex(const std::string& hex) {
  std::string out;
  for (size_t i = 0; i < hex.size(); i += 2) out += char(std::stoi(hex.substr(i, 2), nullptr, 16));
  return out;
}

// What the reader says of a pickle; empty when it accepts it.
std::string Refusal(const std::string& bytes) {
  try {
    Pickle("model.pkl", ToBytes(bytes));
    return "";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find("model.pkl: byte "), 0u) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    return e.what();
  }
}

void ExpectRefused(const std::string& bytes, const std::string& words) {
  const std::string refusal = Refusal(bytes);
  EXPECT_NE(refusal.find(words), std::string::npos)
      << "'" << refusal << "' lacks '" << words << "'";
}

NpyArray ArrayIn(const std::string& value) {
  const Pickle p("model.pkl", ToBytes(File(value)));
  return ArrayOf("model.pkl", "array", p.root());
}

void ExpectNoArray(const std::string& value, const std::string& words) {
  try {
    ArrayIn(value);
    ADD_FAILURE() << "accepted, expected: " << words;
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
  }
}

// Written by CPython 3 for protocols 0 to 4:
// {'n': None, 't': True, 'f': False, 'ints': [1, -2, 70000, -3000000000, 300], 'again': the same
//  list, 'real': -2.5, 'text': 'a\u00fc\\\n\U0001F600', 'tup': ((), (1,), (1, 2), (1, 2, 3),
//  (1, 2, 3, 4)), 'od': OrderedDict(k=0)}
const char* const kFromPython[] = {
    "286470300a566e0a70310a4e7356740a70320a4930310a7356660a70330a4930300a7356696e74730a70340a286c70"
    "350a49310a61492d320a614937303030300a614c2d333030303030303030304c0a61493330300a617356616761696e"
    "0a70360a67350a73567265616c0a70370a462d322e350a7356746578740a70380a5661fc5c75303035635c75303030"
    "615c5530303031663630300a70390a73567475700a7031300a2828742849310a747031310a2849310a49320a747031"
    "320a2849310a49320a49330a747031330a2849310a49320a49330a49340a747031340a747031350a73566f640a7031"
    "360a63636f6c6c656374696f6e730a4f726465726564446963740a7031370a2874527031380a566b0a7031390a4930"
    "0a73732e",
    "7d71002858010000006e71014e58010000007471024930310a58010000006671034930300a5804000000696e747371"
    "045d7105284b014afeffffff4a701101004c2d333030303030303030304c0a4d2c01655805000000616761696e7106"
    "680558040000007265616c710747c0040000000000005804000000746578747108580900000061c3bc5c0af09f9880"
    "71095803000000747570710a2829284b0174710b284b014b0274710c284b014b024b0374710d284b014b024b034b04"
    "74710e74710f58020000006f64711063636f6c6c656374696f6e730a4f726465726564446963740a71112952711258"
    "010000006b71134b0073752e",
    "80027d71002858010000006e71014e5801000000747102885801000000667103895804000000696e747371045d7105"
    "284b014afeffffff4a701101008a0500a22f4dff4d2c01655805000000616761696e7106680558040000007265616c"
    "710747c0040000000000005804000000746578747108580900000061c3bc5c0af09f988071095803000000747570"
    "710a28294b0185710b4b014b0286710c4b014b024b0387710d284b014b024b034b0474710e74710f58020000006f64"
    "711063636f6c6c656374696f6e730a4f726465726564446963740a71112952711258010000006b71134b0073752e",
    "80037d71002858010000006e71014e5801000000747102885801000000667103895804000000696e747371045d7105"
    "284b014afeffffff4a701101008a0500a22f4dff4d2c01655805000000616761696e7106680558040000007265616c"
    "710747c0040000000000005804000000746578747108580900000061c3bc5c0af09f988071095803000000747570"
    "710a28294b0185710b4b014b0286710c4b014b024b0387710d284b014b024b034b0474710e74710f58020000006f64"
    "711063636f6c6c656374696f6e730a4f726465726564446963740a71112952711258010000006b71134b0073752e",
    "800495b6000000000000007d94288c016e944e8c017494888c016694898c04696e7473945d94284b014afeffffff4a"
    "701101008a0500a22f4dff4d2c01658c05616761696e9468058c047265616c9447c0040000000000008c0474657874"
    "948c0961c3bc5c0af09f9880948c037475709428294b0185944b014b0286944b014b024b038794284b014b024b034b"
    "04749474948c026f64948c0b636f6c6c656374696f6e73948c0b4f726465726564446963749493942952948c016b94"
    "4b0073752e",
};

TEST(Pickle, ReadsEveryProtocolOfPython) {
  for (const char* hex : kFromPython) {
    const Pickle p("model.pkl", ToBytes(FromHex(hex)));
    const PickleValue& root = p.root();
    ASSERT_EQ(root.kind, Kind::kDict);
    EXPECT_EQ(root.items.size(), 18u);
    EXPECT_EQ(root.Find("n")->kind, Kind::kNone);
    EXPECT_EQ(root.Find("t")->integer, 1);
    EXPECT_EQ(root.Find("f")->kind, Kind::kBool);
    const auto& ints = root.Find("ints")->items;
    const int64_t expected[] = {1, -2, 70000, -3000000000, 300};
    ASSERT_EQ(ints.size(), 5u);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(ints[i]->integer, expected[i]);
    EXPECT_EQ(root.Find("again"), root.Find("ints"));
    EXPECT_EQ(root.Find("real")->real, -2.5);
    EXPECT_EQ(root.Find("text")->text, "a\xc3\xbc\\\n\xf0\x9f\x98\x80");
    ASSERT_EQ(root.Find("tup")->items.size(), 5u);
    for (size_t i = 0; i < 5; ++i) EXPECT_EQ(root.Find("tup")->items[i]->items.size(), i);
    EXPECT_EQ(root.Find("od")->Find("k")->integer, 0);
    EXPECT_EQ(root.Find("absent"), nullptr);
  }
}

TEST(Pickle, ReadsBytesOfEitherPython) {
  // {'raw': b'\x00\xffz'} by CPython 3, protocols 2 (_codecs.encode) and 3 (SHORT_BINBYTES).
  for (const char* hex : {"80027d710058030000007261777101635f636f646563730a656e636f64650a7102580400"
                          "000000c3bf7a71035806"
                          "0000006c6174696e317104867105527106732e",
                          "80037d710058030000007261777101430300ff7a7102732e"}) {
    const Pickle p("model.pkl", ToBytes(FromHex(hex)));
    EXPECT_EQ(p.root().Find("raw")->kind, Kind::kBytes);
    EXPECT_EQ(p.root().Find("raw")->text, std::string("\0\xffz", 3));
  }
  // Python 2, protocol 0: a quoted string.
  const Pickle p("model.pkl", ToBytes("S'a\\x00\\'\\\\\\n\\t\\r'\n."));
  EXPECT_EQ(p.root().text, std::string("a\0'\\\n\t\r", 7));
}

TEST(Pickle, NamesTheHostileClass) {
  ExpectRefused("cos\nsystem\n(S'true'\ntR.", "class os.system");
  ExpectRefused("\x80\x04\x8c\x02os\x8c\x06system\x93\x8c\x04true\x85R.", "class os.system");
  ExpectRefused(File(Class("__builtin__", "eval")), "class __builtin__.eval");
  ExpectRefused(File(Class("builtins", "getattr")), "class builtins.getattr");
  ExpectRefused(File(Class("subprocess", "Popen")), "class subprocess.Popen");
  ExpectRefused(File(Class("numpy", "load")), "class numpy.load");
  ExpectRefused(File(Class("numpy.core.multiarray", "fromfile")), "fromfile");
  ExpectRefused(File(Class("os\x1b[2J", std::string(500, 'a'))), "class os?[2J.aaa");
  ExpectRefused("\x80\x02" + Class("os", "system"), "class os.system");
}

TEST(Pickle, NamesTheRefusedOpcode) {
  ExpectRefused("(S'true'\nios\nsystem\n.", "opcode INST");
  ExpectRefused(Op('(', Class("numpy", "ndarray")) + "o.", "opcode OBJ");
  ExpectRefused("Pfile\n.", "opcode PERSID");
  ExpectRefused("NQ.", "a file that has no storages");
  ExpectRefused("\x82\x01.", "opcode EXT1");
  ExpectRefused(std::string("\x83\x01\x00.", 4), "opcode EXT2");
  ExpectRefused(std::string("\x84\x01\x00\x00\x00.", 6), "opcode EXT4");
  ExpectRefused("\x8f.", "opcode EMPTY_SET");
  ExpectRefused("(\x91.", "opcode FROZENSET");
  ExpectRefused(Class("numpy", "ndarray") + ")}\x92.", "opcode NEWOBJ_EX");
  ExpectRefused("\x96\x01.", "opcode BYTEARRAY8");
  ExpectRefused("\x97.", "opcode NEXT_BUFFER");
  ExpectRefused("\xff.", "opcode 0xff");
  ExpectRefused("\x80\x05N.", "protocol 5");
}

TEST(Pickle, RefusesBrokenPrograms) {
  for (const char* program : {"",
                              ".",
                              "N",
                              "0.",
                              "1.",
                              "2.",
                              "a.",
                              "Na.",
                              "NNa.",
                              "]Ns",
                              "}NNNs",
                              "NNs.",
                              "(Na.",
                              "((.",
                              "}(Nu.",
                              "e.",
                              "(e.",
                              "t.",
                              "\x85.",
                              "N\x87.",
                              "R.",
                              "NR.",
                              "N)R.",
                              "Nb.",
                              "}}b.",
                              "\x81.",
                              "N)\x81.",
                              "\x93.",
                              "NN\x93.",
                              "h\x01.",
                              "g7\n.",
                              "g-1\n.",
                              "Np-1\n.",
                              "gx\n.",
                              "q\x01.",
                              "N(q\x01.",
                              "I\n.",
                              "I1x\n.",
                              "I99999999999999999999\n.",
                              "L1e3\n.",
                              "F\n.",
                              "F1,5\n.",
                              "Sabc\n.",
                              "S'abc\n.",
                              "S'\n.",
                              "S'\\x4'\n.",
                              "S'\\q'\n.",
                              "S'\\'\n.",
                              "V\\u00\n.",
                              "V\\U00110000\n.",
                              "cnumpy\n",
                              "cnumpy\nndarray",
                              "\x8a\x09"
                              "123456789."})
    EXPECT_NE(Refusal(program), "") << program;
  // Constructions of accepted classes that mean nothing.
  const std::string encode = Class("_codecs", "encode");
  ExpectRefused(Reduce(encode, Tuple({Text("a"), Text("rot13")})) + ".", "latin1");
  ExpectRefused(Reduce(encode, Tuple({Text("\xe2\x82\xac"), Text("latin1")})) + ".", "latin1");
  ExpectRefused(Reduce(encode, Tuple({Text("\xc3"), Text("latin1")})) + ".", "latin1");
  ExpectRefused(Reduce(encode, Tuple({})) + ".", "latin1");
  ExpectRefused(Reduce(Class("copy_reg", "_reconstructor"), Tuple({})) + ".", "constructor");
  ExpectRefused(Reduce(Class("copy_reg", "_reconstructor"), Tuple({encode})) + ".", "function");
  ExpectRefused(Reduce(Class("builtins", "object"), Tuple({})) + ".", "function");
  ExpectRefused(Reduce(Class("collections", "OrderedDict"), Tuple({"]"})) + ".", "OrderedDict");
  ExpectRefused(Reduce(Class("numpy", "ndarray"), Tuple({"N", "N", "N", "N", "N"})) + ".", "5 arg");
}

TEST(Pickle, SizesBeyondTheFileAreRefused) {
  const std::string huge(8, '\xff');
  for (const char* opcode : {"T", "X", "B", "\x8b", "\x8d", "\x8e"})
    EXPECT_NE(Refusal(opcode + huge + "."), "") << opcode;
  ExpectRefused(
      "U\x05"
      "abc.",
      "ends");
}

TEST(Pickle, MemoryStaysBounded) {
  // A text that is encoded again and again.
  std::string bomb =
      Text(std::string(10000, 'a')) + "q\x01" + "0" + Class("_codecs", "encode") + "q\x02" + "0";
  std::string again = bomb;
  for (int i = 0; i < 20; ++i) again += "h\x02h\x01\x85R";
  ExpectRefused(again + ".", "exceed");
  ExpectRefused(std::string(1'000'001, 'N') + ".", "values");
  std::string memos = "N";
  for (uint32_t i = 0; i <= 1'000'000; ++i) memos += Op('r', Raw(i));
  ExpectRefused(memos + ".", "memo");
  EXPECT_EQ(Refusal(std::string("Nr\xff\xff\xff\xff.", 7)), "");  // a large index is only a number
  EXPECT_EQ(Refusal(std::string(500'000, ']') + "."), "");
  EXPECT_EQ(Refusal(std::string(300'000, ']') + std::string(299'999, 'a') + "."), "");  // deep
}

TEST(PickleArrays, NumpyArrays) {
  const NpyArray a = ArrayIn(Floats({2, 3}, {1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(a.shape, (std::vector<size_t>{2, 3}));
  EXPECT_EQ(a.values, (std::vector<double>{1, 2, 3, 4, 5, 6}));
  const auto fortran =
      ArrayIn(Array({2, 3}, Dtype("f8"), Bytes(Raw(std::vector<double>{1, 4, 2, 5, 3, 6})), true));
  EXPECT_EQ(fortran.values, a.values);
  EXPECT_EQ(
      ArrayIn(Array({2}, Dtype("u4"), Bytes(Raw(std::vector<uint32_t>{7, 4294967295u})))).values,
      (std::vector<double>{7, 4294967295.0}));
  EXPECT_EQ(ArrayIn(Array({1}, Dtype("u1", "|"), Bytes("\x05"))).values[0], 5);
  EXPECT_EQ(ArrayIn(Int(-3)).values[0], -3);
  const auto scalar = ArrayIn(
      Reduce(Class("numpy._core.multiarray", "scalar"), Tuple({Dtype("f8"), Bytes(Raw(2.5))})));
  EXPECT_TRUE(scalar.shape.empty());
  EXPECT_EQ(scalar.values[0], 2.5);
}

TEST(PickleArrays, RefusesWhatDisagrees) {
  const std::string data = Bytes(std::string(24, '\1'));
  ExpectNoArray(Array({2, 4}, Dtype("f4"), data), "array: holds 24 bytes");
  ExpectNoArray(Array({1 << 30, 1 << 30, 1 << 30, 1 << 30}, Dtype("f8"), data), "too large shape");
  ExpectNoArray(Array({-1}, Dtype("f4"), data), "shape");
  ExpectNoArray(Array({6}, Dtype("f4", ">"), data), "little-endian");
  ExpectNoArray(Array({3}, Dtype("O8"), data), "object arrays are not supported");
  ExpectNoArray(Array({3}, Dtype("S8"), data), "text");
  ExpectNoArray(Array({3}, Dtype("f4', 'shape': (9"), data), "no numeric dtype");
  ExpectNoArray(Array({3}, Dtype("f8"), "]"), "block of bytes");
  ExpectNoArray(Array({3}, "N", data), "no numeric dtype");
  ExpectNoArray(Object(Class("numpy", "ndarray"), "N"), "unknown form");
  ExpectNoArray(Reduce(Class("numpy", "ndarray"), Tuple({})), "without its state");
  ExpectNoArray(Text("abc"), "no array");
  ExpectNoArray("]", "no array");
  ExpectNoArray(Class("numpy", "ndarray"), "no array");
}

std::string Csc(const std::vector<int>& shape,
                const std::vector<int32_t>& indices,
                const std::vector<int32_t>& indptr,
                const std::vector<double>& data) {
  return Object(Class("scipy.sparse._csc", "csc_matrix"),
                Dict({{"_shape", Shape(shape)},
                      {"indices", Ints({int(indices.size())}, indices)},
                      {"indptr", Ints({int(indptr.size())}, indptr)},
                      {"data", Doubles({int(data.size())}, data)}}));
}

TEST(PickleArrays, SparseMatrices) {
  const NpyArray a = ArrayIn(Csc({2, 3}, {1, 0, 1}, {0, 1, 1, 3}, {5, 6, 7}));
  EXPECT_EQ(a.shape, (std::vector<size_t>{2, 3}));
  EXPECT_EQ(a.values, (std::vector<double>{0, 0, 6, 5, 0, 7}));
  // Python 2's way of making the object, and the older name of its shape.
  const NpyArray b = ArrayIn(
      Reduce(
          Class("copy_reg", "_reconstructor"),
          Tuple({Class("scipy.sparse.csc", "csc_matrix"), Class("__builtin__", "object"), "N"})) +
      Dict({{"shape", Shape({1, 1})},
            {"indices", Ints({1}, {0})},
            {"indptr", Ints({2}, {0, 1})},
            {"data", Doubles({1}, {4})}}) +
      "b");
  EXPECT_EQ(b.values, (std::vector<double>{4}));
  ExpectNoArray(Csc({2, 3}, {2, 0, 1}, {0, 1, 1, 3}, {5, 6, 7}), "'indices'");
  ExpectNoArray(Csc({2, 3}, {-1, 0, 1}, {0, 1, 1, 3}, {5, 6, 7}), "'indices'");
  ExpectNoArray(Csc({2, 3}, {1, 0, 1}, {0, 1, 1, 4}, {5, 6, 7}), "'indptr'");
  ExpectNoArray(Csc({2, 3}, {1, 0, 1}, {0, 3, 1, 3}, {5, 6, 7}), "overlap");
  ExpectNoArray(Csc({2, 3}, {1, 0, 1}, {0, 1, 3}, {5, 6, 7}), "column starts");
  ExpectNoArray(Csc({2, 3}, {1, 0}, {0, 1, 1, 3}, {5, 6, 7}), "row indices");
  ExpectNoArray(Csc({1 << 30, 1 << 30}, {}, {0}, {}), "too large shape");
  ExpectNoArray(Csc({0, 3}, {}, {0}, {}), "too large shape");
  ExpectNoArray(Object(Class("scipy.sparse.csc", "csc_matrix"), Dict({})), "'shape'");
}

std::string Ch(const std::string& x) { return Object(Class("chumpy.ch", "Ch"), Dict({{"x", x}})); }
std::string Select(const std::string& a, const std::string& idxs, const std::string& shape) {
  return Object(Class("chumpy.reordering", "Select"),
                Dict({{"a", a}, {"idxs", idxs}, {"preferred_shape", shape}}));
}

TEST(PickleArrays, ChumpyWrappers) {
  const std::string a = Doubles({2, 2}, {1, 2, 3, 4});
  EXPECT_EQ(ArrayIn(Ch(a)).values, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(ArrayIn(Ch(Ch(a))).shape, (std::vector<size_t>{2, 2}));
  const NpyArray s = ArrayIn(Select(Ch(a), Ints({2}, {3, 0}), Shape({2, 1})));
  EXPECT_EQ(s.shape, (std::vector<size_t>{2, 1}));
  EXPECT_EQ(s.values, (std::vector<double>{4, 1}));
  EXPECT_EQ(ArrayIn(Select(a, Ints({1}, {2}), "N")).shape, (std::vector<size_t>{1}));
  ExpectNoArray(Select(a, Ints({1}, {4}), "N"), "'idxs'");
  ExpectNoArray(Select(a, Ints({1}, {1}), Shape({3})), "selects 1");
  ExpectNoArray(Object(Class("chumpy.ch", "Ch"), Dict({})), "'x'");
  // A wrapper around itself: memo 1 is the object, its state holds it.
  ExpectNoArray(Class("chumpy.ch", "Ch") + ")\x81q\x01}" + Text("x") + "h\x01sb", "wrapped");
}

}  // namespace
}  // namespace cosplat::test

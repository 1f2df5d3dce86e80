// LoadFlameModel: both kinds of file give the same model; faults are named.
#include <gtest/gtest.h>

#include <algorithm>

#include "flame/io/pickle.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/npz.h"
#include "tests/flame/pickle_builder.h"
#include "tests/flame/random_model.h"
#include "tests/support/temporary_folder.h"

namespace cosplat::test {
namespace {

using Items = std::vector<std::pair<std::string, std::string>>;

void ExpectSameModel(const FlameModel& a, const FlameModel& b) {
  EXPECT_EQ(a.vertex_count, b.vertex_count);
  EXPECT_EQ(a.shape_count, b.shape_count);
  EXPECT_EQ(a.expression_count, b.expression_count);
  EXPECT_EQ(a.template_vertices, b.template_vertices);
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.shape_directions, b.shape_directions);
  EXPECT_EQ(a.expression_directions, b.expression_directions);
  EXPECT_EQ(a.pose_directions, b.pose_directions);
  EXPECT_EQ(a.joint_regressor, b.joint_regressor);
  EXPECT_EQ(a.skinning_weights, b.skinning_weights);
  EXPECT_EQ(a.parents, b.parents);
  EXPECT_EQ(a.redistributable, b.redistributable);
}

class ModelFile : public ::testing::Test {
 protected:
  std::string WritePickle(const Items& items) {
    const std::string path = folder_ / "model.pkl";
    WriteFileAtomically(path, pickle::File(pickle::Dict(items)));
    return path;
  }

  // Loading fails with a message that holds every one of `words`.
  void ExpectRefused(const std::string& path, const std::vector<std::string>& words) {
    try {
      LoadFlameModel(path);
      ADD_FAILURE() << "accepted, expected: " << words[0];
    } catch (const Error& e) {
      for (const std::string& w : words)
        EXPECT_NE(std::string(e.what()).find(w), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find(path), std::string::npos) << e.what();
    }
  }

  // The model's pickle with one item replaced (or removed, when `value` is empty).
  std::string WriteSpoiled(const std::string& key, const std::string& value) {
    Items items = pickle::ModelItems(model_);
    std::erase_if(items, [&](const auto& item) { return item.first == key; });
    if (!value.empty()) items.emplace_back(key, value);
    return WritePickle(items);
  }

  const FlameModel model_ = RandomModel(7, 3, 2);
  TemporaryFolder folder_;
};

TEST_F(ModelFile, PickleOfFlamesShape) {
  const FlameModel loaded = LoadFlameModel(WritePickle(pickle::ModelItems(model_)));
  ExpectSameModel(loaded, model_);  // zero shape directions 3 to 299 are gone again
  EXPECT_EQ(loaded.name, "model.pkl");
  EXPECT_EQ(loaded.sha256, Sha256OfFile(folder_ / "model.pkl"));
}

TEST_F(ModelFile, ChumpyWrappedAndDenseArraysAreTheSame) {
  const auto ch = [](const std::string& x) {
    return pickle::Object(pickle::Class("chumpy.ch", "Ch"), pickle::Dict({{"x", x}}));
  };
  Items items = pickle::ModelItems(model_);
  for (auto& [key, value] : items) {
    if (key == "J_regressor")
      value = pickle::Floats({5, 7}, model_.joint_regressor);
    else if (key == "v_template" || key == "shapedirs" || key == "weights")
      value = ch(value);
    else if (key == "kintree_table")  // as FLAME stores it: the root's parent is 2^32 - 1
      value = pickle::Array({2, 5},
                            pickle::Dtype("u4"),
                            pickle::Bytes(pickle::Raw(
                                std::vector<uint32_t>{0xffffffffu, 0, 1, 1, 1, 0, 1, 2, 3, 4})));
  }
  ExpectSameModel(LoadFlameModel(WritePickle(items)), model_);
}

TEST_F(ModelFile, NpzRoundTrip) {
  for (bool redistributable : {false, true}) {
    FlameModel model = model_;
    model.redistributable = redistributable;
    WriteFlameModelNpz(folder_ / "model.npz", model);
    const FlameModel loaded = LoadFlameModel(folder_ / "model.npz");
    ExpectSameModel(loaded, model);
    EXPECT_EQ(loaded.name, "model.npz");
    EXPECT_EQ(loaded.sha256, Sha256OfFile(folder_ / "model.npz"));
    const std::vector<char> bytes = ReadFile(folder_ / "model.npz");
    EXPECT_EQ(loaded.file, redistributable ? bytes : std::vector<char>());
    ExpectSameModel(ParseFlameModel("elsewhere/model.npz", bytes), model);
  }
}

TEST_F(ModelFile, KeepsLandmarks) {
  FlameModel model = model_;
  model.landmarks = {{33, {0, 1, 2}, {0.5, 0.25, 0.25}, 1}, {468, {3, 3, 3}, {1, 0, 0}, 1.5}};
  const std::string path = folder_ / "model.npz";
  WriteFlameModelNpz(path, model);
  const FlameModel loaded = LoadFlameModel(path);
  ASSERT_EQ(loaded.landmarks.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(loaded.landmarks[i].landmark, model.landmarks[i].landmark);
    EXPECT_EQ(loaded.landmarks[i].vertices, model.landmarks[i].vertices);
    EXPECT_EQ(loaded.landmarks[i].barycentric, model.landmarks[i].barycentric);
    EXPECT_EQ(loaded.landmarks[i].looseness, model.landmarks[i].looseness);
  }
  const auto refused =
      [&](const char* array, std::vector<size_t> shape, std::vector<float> values) {
        WriteFlameModelNpz(path, model);
        Npz npz = Npz::Read(path);
        npz.Add(array, std::move(shape), values);
        npz.Write(path);
        ExpectRefused(path, {"landmark"});
      };
  refused("landmark_indices", {2}, {33, 478});
  refused("landmark_vertices", {2, 3}, {0, 1, 2, 3, 3, 7});
  refused("landmark_barycentric", {2, 3}, {0.5f, 0.25f, 0.5f, 1, 0, 0});
  refused("landmark_looseness", {2}, {1, 0});
  refused("landmark_looseness", {1}, {1});
}

TEST_F(ModelFile, ModelWithoutDirections) {
  const FlameModel bare = RandomModel(7, 0, 0);
  WriteFlameModelNpz(folder_ / "model.npz", bare);
  ExpectSameModel(LoadFlameModel(folder_ / "model.npz"), bare);
}

TEST_F(ModelFile, TrailingZeroDirectionsAreDroppedInBothGroups) {
  FlameModel model = RandomModel(7, 3, 3);
  const size_t n = 21;
  std::fill(model.shape_directions.begin() + n, model.shape_directions.end(), 0.0f);
  std::fill_n(model.expression_directions.begin() + n, n, 0.0f);  // a hole stays
  WriteFlameModelNpz(folder_ / "model.npz", model);
  const FlameModel loaded = LoadFlameModel(folder_ / "model.npz");
  EXPECT_EQ(loaded.shape_count, 1);
  EXPECT_EQ(loaded.expression_count, 3);
  EXPECT_EQ(loaded.expression_directions, model.expression_directions);
  ExpectSameModel(LoadFlameModel(WritePickle(pickle::ModelItems(model))), loaded);
}

TEST_F(ModelFile, OtherArrayNames) {
  WriteFlameModelNpz(folder_ / "model.npz", model_);
  const Npz source = Npz::Read(folder_ / "model.npz");
  const auto floats = [&](const char* name) {
    const auto& v = source.Get(name).values;
    return std::vector<float>(v.begin(), v.end());
  };
  std::vector<int32_t> faces;
  for (double x : source.Get("f").values) faces.push_back(int32_t(x));
  Npz npz;
  npz.Add("v_template", {7, 3}, floats("v_template"));
  npz.Add("faces", {model_.faces.size(), 3}, faces);
  npz.Add("shapedirs60_open", {7, 3, 5}, floats("shapedirs"));
  npz.Add("posedirs_open", {7, 3, 36}, floats("posedirs"));
  npz.Add("weights", {7, 5}, floats("weights"));
  npz.Add("J_regressor", {5, 7}, floats("J_regressor"));
  npz.Add("parents", {5}, std::vector<int32_t>{-1, 0, 1, 1, 1});
  npz.Write(folder_ / "open.npz");
  const FlameModel loaded = LoadFlameModel(folder_ / "open.npz");
  EXPECT_EQ(loaded.shape_count, 5);  // without n_shape, the first 300 are shape
  EXPECT_EQ(loaded.expression_count, 0);
  EXPECT_EQ(loaded.pose_directions, model_.pose_directions);
  EXPECT_EQ(loaded.parents, model_.parents);
  EXPECT_FALSE(loaded.redistributable);

  npz.Add("shapedirs_more", {7, 3, 5}, floats("shapedirs"));
  npz.Write(folder_ / "open.npz");
  ExpectRefused(folder_ / "open.npz", {"shapedirs60_open", "ambiguous", "shapedirs_more"});
}

TEST_F(ModelFile, FaultsNameFileArrayAndShape) {
  const std::vector<float> zeros(21 * 36);
  ExpectRefused(WriteSpoiled("weights", ""), {"weights: array is missing"});
  ExpectRefused(WriteSpoiled("weights", pickle::Floats({6, 5}, std::vector<float>(30, 0.2f))),
                {"weights: has shape [6, 5], expected [7, 5]"});
  ExpectRefused(WriteSpoiled("v_template", pickle::Floats({7, 2}, std::vector<float>(14))),
                {"v_template: has shape [7, 2]"});
  ExpectRefused(WriteSpoiled("v_template", pickle::Floats({8, 3}, std::vector<float>(24))),
                {"has shape", "expected [8, 3"});
  ExpectRefused(WriteSpoiled("v_template", pickle::Floats({7, 3}, std::vector<float>(21, NAN))),
                {"template_vertices", "not finite"});
  ExpectRefused(WriteSpoiled("posedirs", pickle::Floats({7, 3, 9}, std::vector<float>(189))),
                {"posedirs: has shape [7, 3, 9], expected [7, 3, 36]"});
  ExpectRefused(WriteSpoiled("f", pickle::Ints({1, 3}, {0, 1, 7})), {"f[2]", "is 7"});
  ExpectRefused(WriteSpoiled("f", pickle::Floats({1, 3}, {0, 1, 1.5f})), {"f[2]", "is 1.5"});
  ExpectRefused(
      WriteSpoiled("kintree_table", pickle::Ints({2, 5}, {-1, 0, 3, 1, 1, 0, 1, 2, 3, 4})),
      {"parents", "joint 2 has parent 3"});
  ExpectRefused(
      WriteSpoiled("kintree_table", pickle::Ints({2, 5}, {-1, 0, 1, 1, 1, 0, 1, 2, 4, 3})),
      {"kintree_table[8]"});
  ExpectRefused(WriteSpoiled("weights", pickle::Floats({7, 5}, std::vector<float>(35, 0.3f))),
                {"skinning_weights", "sums to 1.5"});
  WriteFileAtomically(folder_ / "list.pkl", pickle::File("]"));
  ExpectRefused(folder_ / "list.pkl", {"does not contain a dictionary"});
  ExpectRefused(folder_ / "absent.pkl", {"absent.pkl"});
  WriteFileAtomically(folder_ / "model.obj", "v 0 0 0\n");
  ExpectRefused(folder_ / "model.obj", {"expected .pkl or .npz"});
}

TEST_F(ModelFile, CountsThatDisagreeWithTheDirections) {
  WriteFlameModelNpz(folder_ / "model.npz", model_);
  Npz npz = Npz::Read(folder_ / "model.npz");
  npz.Add("n_expr", {}, std::vector<int32_t>{3});
  npz.Write(folder_ / "model.npz");
  ExpectRefused(folder_ / "model.npz", {"shapedirs", "[7, 3, 5]", "3 + 3"});
}

// Every prefix of a valid pickle, and random damage to it: an Error or a model, never a crash and
// never a broken model. (Run under the address and undefined-behaviour sanitizers as well.)
class DamagedPickle : public ::testing::Test {
 protected:
  static Items SmallItems() {
    Items items = pickle::ModelItems(RandomModel(3, 1, 1));
    for (auto& [key, value] : items)  // 301 directions would be mostly zeros to damage
      if (key == "shapedirs") value = pickle::Floats({3, 3, 2}, std::vector<float>(18, 0.5f));
    return items;
  }
  // Reads every array, as LoadFlameModel does, without the way over the disk.
  static bool Reads(const std::string& bytes) {
    try {
      const Pickle p("model.pkl", {bytes.begin(), bytes.end()});
      for (const auto& [key, unused] : SmallItems())
        if (const PickleValue* value = p.root().Find(key)) ArrayOf("model.pkl", key, *value);
      return true;
    } catch (const Error&) {
      return false;
    }
  }
  const std::string valid_ = pickle::File(pickle::Dict(SmallItems()));
};

TEST_F(DamagedPickle, TruncatedAnywhereIsAnError) {
  for (size_t n = 0; n < valid_.size(); ++n) EXPECT_FALSE(Reads(valid_.substr(0, n))) << n;
}

TEST_F(DamagedPickle, RandomDamageNeverCrashes) {
  std::mt19937 rng(2024);
  const auto pick = [&](size_t n) { return size_t(rng() % n); };
  int accepted = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string bytes = valid_;
    for (size_t k = 1 + pick(4); k > 0; --k) {
      const size_t at = pick(bytes.size());
      const size_t span = 1 + pick(12);
      switch (pick(4)) {
        case 0:
          bytes[at] = char(pick(256));
          break;
        case 1:
          bytes[at] ^= char(1 << pick(8));
          break;
        case 2:
          bytes.erase(at, span);
          break;
        default:
          bytes.insert(at, bytes.substr(pick(bytes.size()), span));
          break;
      }
    }
    accepted += Reads(bytes);
  }
  EXPECT_LT(accepted, 5000);
}

TEST_F(DamagedPickle, WhatLoadsIsValid) {
  TemporaryFolder folder;
  const std::string path = folder / "model.pkl";
  std::mt19937 rng(7);
  for (int i = 0; i < 300; ++i) {
    std::string bytes = valid_;
    bytes[rng() % bytes.size()] = char(rng());
    WriteFileAtomically(path, bytes);
    FlameModel model;
    try {
      model = LoadFlameModel(path);
    } catch (const Error&) {
      continue;
    }
    EXPECT_NO_THROW(Validate(model));
  }
}

}  // namespace
}  // namespace cosplat::test

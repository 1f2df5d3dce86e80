// Assembles pickles opcode by opcode, for tests. Every function returns the bytes that leave one
// value on the stack.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "flame/model.h"

namespace cosplat::test::pickle {

template <class T>
std::string Raw(const T& value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}
template <class T>
std::string Raw(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// An opcode and its argument. (append: g++ 12 warns falsely about "c" + std::string.)
inline std::string Op(char opcode, const std::string& argument) {
  return std::string(1, opcode).append(argument);
}
inline std::string Int(int32_t value) { return Op('J', Raw(value)); }
inline std::string Sized(char opcode, const std::string& bytes) {
  return Op(opcode, Raw(uint32_t(bytes.size())) + bytes);
}
inline std::string Text(const std::string& utf8) { return Sized('X', utf8); }
inline std::string Bytes(const std::string& bytes) { return Sized('B', bytes); }
inline std::string Python2String(const std::string& bytes) { return Sized('T', bytes); }
inline std::string Class(const std::string& module, const std::string& name) {
  return "c" + module + "\n" + name + "\n";
}
inline std::string Tuple(const std::vector<std::string>& items) {
  std::string out = "(";
  for (const auto& item : items) out += item;
  return out + "t";
}
inline std::string Dict(const std::vector<std::pair<std::string, std::string>>& items) {
  std::string out = "}(";
  for (const auto& [key, value] : items) out += Text(key) + value;
  return out + "u";
}
inline std::string Reduce(const std::string& callable, const std::string& arguments) {
  return callable + arguments + "R";
}
// An object of a new-style class with a state, as protocol 2 writes it.
inline std::string Object(const std::string& type, const std::string& state) {
  return type + ")\x81" + state + "b";
}
inline std::string File(const std::string& value) { return "\x80\x02" + value + "."; }

inline std::string Dtype(const std::string& code, const std::string& order = "<") {
  return Reduce(Class("numpy", "dtype"), Tuple({Text(code), Int(0), Int(1)})) +
         Tuple({Int(3), Text(order), "N", "N", "N", Int(-1), Int(-1), Int(0)}) + "b";
}
inline std::string Shape(const std::vector<int>& shape) {
  std::vector<std::string> items;
  for (int extent : shape) items.push_back(Int(extent));
  return Tuple(items);
}
inline std::string Array(const std::vector<int>& shape,
                         const std::string& dtype,
                         const std::string& data,
                         bool fortran = false) {
  return Reduce(Class("numpy.core.multiarray", "_reconstruct"),
                Tuple({Class("numpy", "ndarray"), Tuple({Int(0)}), Text("b")})) +
         Tuple({Int(1), Shape(shape), dtype, fortran ? "\x88" : "\x89", data}) + "b";
}
inline std::string Floats(const std::vector<int>& shape, const std::vector<float>& values) {
  return Array(shape, Dtype("f4"), Python2String(Raw(values)));
}
inline std::string Doubles(const std::vector<int>& shape, const std::vector<double>& values) {
  return Array(shape, Dtype("f8"), Bytes(Raw(values)));
}
inline std::string Ints(const std::vector<int>& shape, const std::vector<int32_t>& values) {
  return Array(shape, Dtype("i4"), Bytes(Raw(values)));
}

// torch's: a storage by its name in the archive, and a tensor that is a view of it.
inline std::string Storage(const std::string& type, const std::string& key, int count) {
  return Tuple({Text("storage"), Class("torch", type), Text(key), Text("cpu"), Int(count)}) + "Q";
}
inline std::string Tensor(const std::string& storage,
                          int offset,
                          const std::vector<int>& shape,
                          const std::vector<int>& strides) {
  return Reduce(Class("torch._utils", "_rebuild_tensor_v2"),
                Tuple({storage,
                       Int(offset),
                       Shape(shape),
                       Shape(strides),
                       "\x89",
                       Reduce(Class("collections", "OrderedDict"), Tuple({}))}));
}

// [K, V, 3] (the model's order) -> [V, 3, K] (the file's), several groups one behind the other.
inline std::vector<float> ToFileOrder(const std::vector<std::vector<float>>& groups, int vertices) {
  const size_t rows = 3 * size_t(vertices);
  size_t columns = 0;
  for (const auto& g : groups) columns += g.size() / rows;
  std::vector<float> out(rows * columns);
  size_t k = 0;
  for (const auto& g : groups)
    for (size_t begin = 0; begin < g.size(); begin += rows, ++k)
      for (size_t r = 0; r < rows; ++r) out[r * columns + k] = g[begin + r];
  return out;
}

// Items of a FLAME pickle of `model` whose directions are laid out as 300 shape, then expression.
inline std::vector<std::pair<std::string, std::string>> ModelItems(const FlameModel& model) {
  const int v = model.vertex_count;
  std::vector<float> shape = model.shape_directions;
  shape.resize(300 * 3 * size_t(v));
  std::vector<int32_t> faces;
  for (const auto& f : model.faces) faces.insert(faces.end(), f.begin(), f.end());
  // The regressor as a csc matrix of every entry.
  std::vector<float> data;
  std::vector<int32_t> indices, indptr = {0};
  for (int c = 0; c < v; ++c) {
    for (int j = 0; j < kFlameJoints; ++j) {
      data.push_back(model.joint_regressor[size_t(j) * v + c]);
      indices.push_back(j);
    }
    indptr.push_back(int32_t(data.size()));
  }
  const int n = int(data.size());
  return {{"bs_type", Python2String("lrotmin")},
          {"v_template", Floats({v, 3}, model.template_vertices)},
          {"f", Ints({int(model.faces.size()), 3}, faces)},
          {"shapedirs",
           Floats({v, 3, 300 + model.expression_count},
                  ToFileOrder({shape, model.expression_directions}, v))},
          {"posedirs", Floats({v, 3, kFlamePoseFeatures}, ToFileOrder({model.pose_directions}, v))},
          {"J_regressor",
           Object(Class("scipy.sparse.csc", "csc_matrix"),
                  Dict({{"_shape", Shape({kFlameJoints, v})},
                        {"indices", Ints({n}, indices)},
                        {"indptr", Ints({v + 1}, indptr)},
                        {"data", Floats({n}, data)},
                        {"format", Python2String("csc")}}))},
          {"weights", Floats({v, kFlameJoints}, model.skinning_weights)},
          {"kintree_table", Ints({2, 5}, {-1, 0, 1, 1, 1, 0, 1, 2, 3, 4})}};
}

}  // namespace cosplat::test::pickle

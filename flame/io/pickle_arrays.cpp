#include <algorithm>

#include "flame/io/pickle.h"
#include "splat/base/error.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

using Kind = PickleValue::Kind;

// Maximum nesting of wrappers: FLAME's files have two levels. Also breaks reference cycles.
constexpr int kMaxDepth = 4;
// Bounds a dense matrix made of few sparse entries: FLAME's joint regressor is 5 x 5023.
constexpr size_t kMaxDenseNumbers = size_t(1) << 24;

class Converter {
 public:
  Converter(const std::string& file, const std::string& name) : file_(file), name_(name) {}

  NpyArray Convert(const PickleValue& value, int depth) const {
    if (depth > kMaxDepth) Fail("is wrapped more than " + std::to_string(kMaxDepth) + " times");
    switch (value.kind) {
      case Kind::kBool:
      case Kind::kInteger:
        return {{}, {double(value.integer)}, "<i8"};
      case Kind::kFloat:
        return {{}, {value.real}, "<f8"};
      case Kind::kObject:
        return ConvertObject(value, depth);
      default:
        Fail("is no array of numbers");
    }
  }

 private:
  [[noreturn]] void Fail(const std::string& problem) const { throw Error(file_, name_, problem); }

  NpyArray ConvertObject(const PickleValue& value, int depth) const {
    switch (value.type) {
      case PickleClass::kArray:
        return ConvertArray(value);
      case PickleClass::kScalar:
        if (value.items.size() != 2) Fail("has a numpy scalar of unknown form");
        return Decode("()", false, *value.items[0], *value.items[1]);
      case PickleClass::kCscMatrix:
        return ConvertCsc(State(value), depth);
      case PickleClass::kChumpy:
        return Convert(Field(State(value), "x"), depth + 1);
      case PickleClass::kChumpySelect:
        return ConvertSelect(State(value), depth);
      case PickleClass::kTensor:
        return ConvertTensor(value);
      case PickleClass::kTensorParameter:
        if (value.items.empty()) Fail("has a parameter of unknown form");
        return Convert(*value.items[0], depth + 1);
      default:
        Fail("is no array of numbers");
    }
  }

  const PickleValue& State(const PickleValue& object) const {
    if (object.state == nullptr) Fail("has an object without its state");
    return *object.state;
  }
  const PickleValue& Field(const PickleValue& state, const char* key) const {
    const PickleValue* field = state.Find(key);
    if (field == nullptr) Fail(std::string("has an object without its '") + key + "'");
    return *field;
  }

  // ndarray state: (version, shape, dtype, is_fortran, data); version is missing in old files.
  NpyArray ConvertArray(const PickleValue& value) const {
    const PickleValue& state = State(value);
    const size_t n = state.items.size();
    if (state.kind != Kind::kTuple || n < 4 || n > 5) Fail("has a numpy state of unknown form");
    const auto item = [&](size_t i) -> const PickleValue& { return *state.items[n - 4 + i]; };
    return Decode(ShapeText(item(0)), item(2).integer != 0, item(1), item(3));
  }

  std::string ShapeText(const PickleValue& shape) const {
    if (shape.kind != Kind::kTuple || shape.items.size() > 32) Fail("has a shape of unknown form");
    std::string text = "(";
    for (const PickleValue* extent : shape.items) {
      if (extent->kind != Kind::kInteger || extent->integer < 0)
        Fail("has a shape of unknown form");
      text += std::to_string(extent->integer) + ",";
    }
    return text + ")";
  }

  // dtype: arguments ("f8", ...), state (version, byte order, ...).
  std::string DtypeText(const PickleValue& dtype) const {
    if (dtype.kind != Kind::kObject || dtype.type != PickleClass::kDtype || dtype.items.empty())
      Fail("has no numeric dtype");
    const std::string& code = dtype.items[0]->text;
    // A quote or a backslash would corrupt the header that is built from it.
    if (code.empty() ||
        code.find_first_not_of("abcdefghijklmnopqrstuvwxyzOSUV0123456789") != std::string::npos)
      Fail("has no numeric dtype");
    const PickleValue* state = dtype.state;
    const bool big = state != nullptr && state->items.size() > 1 && state->items[1]->text == ">";
    return (big ? ">" : "<") + code;
  }

  NpyArray Decode(const std::string& shape,
                  bool fortran,
                  const PickleValue& dtype,
                  const PickleValue& data) const {
    if (data.kind != Kind::kBytes && data.kind != Kind::kText)
      Fail("has its numbers in no block of bytes");
    return Decode(shape, fortran, DtypeText(dtype), data.text);
  }

  // Prepends a .npy header to the raw bytes, so that a single parser validates shapes and types.
  NpyArray Decode(const std::string& shape,
                  bool fortran,
                  const std::string& dtype,
                  const std::string& data) const {
    const std::string header = "{'descr': '" + dtype +
                               "', 'fortran_order': " + (fortran ? "True" : "False") +
                               ", 'shape': " + shape + "}";
    std::vector<char> npy = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0};
    npy.push_back(char(header.size() & 255));
    npy.push_back(char(header.size() >> 8));
    npy.insert(npy.end(), header.begin(), header.end());
    npy.insert(npy.end(), data.begin(), data.end());
    NpyArray array;
    if (!ParseNpy(file_, name_, npy, array)) Fail("is text, expected numbers");
    return array;
  }

  // An array of integers, each below `limit`.
  std::vector<size_t> Indices(const PickleValue& state,
                              const char* key,
                              size_t limit,
                              int depth) const {
    std::vector<size_t> indices;
    for (double x : Convert(Field(state, key), depth + 1).values) {
      if (!(x >= 0 && x < double(limit)) || x != double(size_t(x)))
        Fail(Format("has a '{}' entry of {}, expected an integer below {}", key, x, limit));
      indices.push_back(size_t(x));
    }
    return indices;
  }

  // A tuple of integers whose product is below kMaxDenseNumbers.
  std::vector<size_t> Shape(const PickleValue& shape) const {
    if (shape.kind != Kind::kTuple) Fail("has a shape of unknown form");
    std::vector<size_t> extents;
    size_t product = 1;
    for (const PickleValue* extent : shape.items) {
      if (extent->kind != Kind::kInteger || extent->integer <= 0 ||
          uint64_t(extent->integer) > kMaxDenseNumbers / product)
        Fail("has an invalid or too large shape");
      extents.push_back(size_t(extent->integer));
      product *= extents.back();
    }
    return extents;
  }

  // Column c of a csc_matrix: rows indices[indptr[c]..indptr[c+1]) with their data.
  NpyArray ConvertCsc(const PickleValue& state, int depth) const {
    const PickleValue* shape_value = state.Find("_shape");
    const auto shape = Shape(shape_value != nullptr ? *shape_value : Field(state, "shape"));
    if (shape.size() != 2) Fail("is a sparse matrix without two dimensions");
    const NpyArray data = Convert(Field(state, "data"), depth + 1);
    const auto rows = Indices(state, "indices", shape[0], depth);
    const auto begin = Indices(state, "indptr", data.size() + 1, depth);
    if (rows.size() != data.size() || begin.size() != shape[1] + 1)
      Fail("is a sparse matrix with " + std::to_string(rows.size()) + " row indices and " +
           std::to_string(begin.size()) + " column starts for " + std::to_string(data.size()) +
           " numbers in " + std::to_string(shape[1]) + " columns");
    if (!std::is_sorted(begin.begin(), begin.end()))
      Fail("is a sparse matrix whose columns overlap");
    NpyArray dense{shape, std::vector<double>(shape[0] * shape[1]), "<f8"};
    for (size_t c = 0; c < shape[1]; ++c)
      for (size_t k = begin[c]; k < begin[c + 1]; ++k)
        dense.values[rows[k] * shape[1] + c] += data.values[k];
    return dense;
  }

  // chumpy's Select: a.ravel()[idxs].reshape(preferred_shape).
  NpyArray ConvertSelect(const PickleValue& state, int depth) const {
    const NpyArray source = Convert(Field(state, "a"), depth + 1);
    NpyArray out{{}, {}, source.dtype};
    for (size_t i : Indices(state, "idxs", source.size(), depth))
      out.values.push_back(source.values[i]);
    out.shape = {out.values.size()};
    const PickleValue* shape = state.Find("preferred_shape");
    if (shape == nullptr || shape->kind == Kind::kNone) return out;
    out.shape = Shape(*shape);
    size_t count = 1;
    for (size_t extent : out.shape) count *= extent;
    if (count != out.values.size())
      Fail(Format("selects {} numbers for a shape of {}", out.values.size(), count));
    return out;
  }

  // A view of a storage: number [i, j, ...] is at offset + i stride[0] + j stride[1] + ...
  NpyArray ConvertTensor(const PickleValue& value) const {
    const auto& arguments = value.items;
    if (arguments.size() < 4 || arguments[0]->kind != Kind::kObject ||
        arguments[0]->type != PickleClass::kStorage || arguments[1]->kind != Kind::kInteger)
      Fail("has a tensor of unknown form");
    const PickleValue& storage = *arguments[0];
    const std::vector<size_t> shape = Shape(*arguments[2]);
    const PickleValue& strides = *arguments[3];
    if (strides.kind != Kind::kTuple || strides.items.size() != shape.size())
      Fail("has a tensor with " + std::to_string(shape.size()) + " extents and other strides");
    const std::string& dtype = storage.items[0]->text;
    const std::string count = std::to_string(storage.items[1]->integer);
    const NpyArray numbers = Decode("(" + count + ",)", false, dtype, storage.text);
    NpyArray out{shape, {}, dtype};
    std::vector<size_t> index(shape.size(), 0);
    size_t total = 1;
    for (size_t extent : shape) total *= extent;
    while (out.values.size() < total) {
      out.values.push_back(NumberAt(numbers, *arguments[1], strides, index));
      for (size_t d = shape.size(); d-- > 0;) {  // the last index is the fastest
        if (++index[d] < shape[d]) break;
        index[d] = 0;
      }
    }
    return out;
  }

  double NumberAt(const NpyArray& numbers,
                  const PickleValue& offset,
                  const PickleValue& strides,
                  const std::vector<size_t>& index) const {
    const double count = double(numbers.size());
    double at = double(offset.integer);
    for (size_t d = 0; d < index.size(); ++d)
      at += double(index[d]) * double(strides.items[d]->integer);
    if (!(at >= 0 && at < count))
      Fail(Format("has a tensor that reaches beyond its storage of {} numbers", numbers.size()));
    return numbers.values[size_t(at)];
  }

  std::string file_, name_;
};

}  // namespace

NpyArray ArrayOf(const std::string& file, const std::string& name, const PickleValue& value) {
  return Converter(file, name).Convert(value, 0);
}

}  // namespace cosplat

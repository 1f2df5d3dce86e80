#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "splat/base/error.h"
#include "splat/base/npz.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as stored");

// Elements of an array, at most: bytes, and ten times as many, fit into a size_t, which a browser's
// has 32 bits for.
constexpr size_t kMaxCount =
    size_t(std::min(uint64_t(1) << 48, uint64_t(std::numeric_limits<size_t>::max()) / 16));

template <class T>
double As(const char* p) {
  T value;
  std::memcpy(&value, p, sizeof(T));
  return double(value);
}

double HalfAt(const char* p) {
  uint16_t bits;
  std::memcpy(&bits, p, sizeof(bits));
  return HalfToDouble(bits);
}

struct Element {
  size_t bytes;
  double (*read)(const char*);
};

// Reader and size of a dtype such as "<f4"; bytes == 0 if it is not numeric.
Element ElementOf(const std::string& dtype) {
  const std::string kind = dtype.size() > 1 ? dtype.substr(1) : "";
  if (kind == "f2") return {2, HalfAt};
  if (kind == "f4") return {4, As<float>};
  if (kind == "f8") return {8, As<double>};
  if (kind == "i1") return {1, As<int8_t>};
  if (kind == "i2") return {2, As<int16_t>};
  if (kind == "i4") return {4, As<int32_t>};
  if (kind == "i8") return {8, As<int64_t>};
  if (kind == "u1" || kind == "b1") return {1, As<uint8_t>};
  if (kind == "u2") return {2, As<uint16_t>};
  if (kind == "u4") return {4, As<uint32_t>};
  if (kind == "u8") return {8, As<uint64_t>};
  return {0, nullptr};
}

// The header is a Python dictionary with three known keys; each value follows its key.
class Header {
 public:
  Header(const std::string& file, const std::string& member, const std::vector<char>& bytes)
      : file_(file), member_(member) {
    if (bytes.size() < 10 || std::memcmp(bytes.data(), "\x93NUMPY", 6) != 0)
      Fail("is not a .npy array");
    const size_t length_bytes = bytes[6] == 1 ? 2 : 4;
    if (bytes.size() < 8 + length_bytes) Fail("ends inside the header");
    uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 8, length_bytes);
    data_begin_ = 8 + length_bytes + length;
    if (bytes.size() < data_begin_) Fail("ends inside the header");
    text_.assign(bytes.data() + 8 + length_bytes, length);
  }

  std::string Descr() const {
    size_t i = ValueOf("descr");
    const char quote = text_[i];
    const size_t end = quote == '\'' || quote == '"' ? text_.find(quote, i + 1) : std::string::npos;
    if (end == std::string::npos) Fail("has a structured dtype, expected a numeric array");
    return text_.substr(i + 1, end - i - 1);
  }

  bool FortranOrder() const { return text_.compare(ValueOf("fortran_order"), 4, "True") == 0; }

  std::vector<size_t> Shape() const {
    std::vector<size_t> shape;
    size_t i = ValueOf("shape");
    if (text_[i] != '(') Fail("has no shape in its header");
    for (++i; i < text_.size() && text_[i] != ')'; ++i) {
      if (text_[i] < '0' || text_[i] > '9') continue;
      size_t extent = 0;
      for (; i < text_.size() && text_[i] >= '0' && text_[i] <= '9'; ++i) {
        if (extent > kMaxCount) Fail("has an invalid or too large shape");
        extent = extent * 10 + (text_[i] - '0');
      }
      shape.push_back(extent);
      --i;
    }
    return shape;
  }

  size_t data_begin() const { return data_begin_; }
  [[noreturn]] void Fail(const std::string& problem) const { throw Error(file_, member_, problem); }

 private:
  size_t ValueOf(const std::string& key) const {
    const size_t found = text_.find("'" + key + "'");
    const size_t colon = found == std::string::npos ? found : text_.find(':', found);
    const size_t value =
        colon == std::string::npos ? colon : text_.find_first_not_of(' ', colon + 1);
    if (value == std::string::npos) Fail("has no " + key + " in its header");
    return value;
  }

  std::string file_, member_, text_;
  size_t data_begin_ = 0;
};

size_t CheckedCount(const Header& header,
                    const std::vector<size_t>& shape,
                    size_t element_bytes,
                    size_t bytes) {
  size_t count = 1;
  for (size_t extent : shape) {
    if (extent != 0 && count > kMaxCount / extent) header.Fail("has an invalid or too large shape");
    count *= extent;
  }
  if (bytes < count * element_bytes)
    header.Fail(Format("holds {} bytes of data, its shape needs {}", bytes, count * element_bytes));
  return count;
}

// Position in Fortran order of the element with index `c_index` in C order.
size_t FortranIndex(const std::vector<size_t>& shape, size_t c_index) {
  size_t index = 0;
  size_t stride = 1;
  for (size_t extent : shape) stride *= extent;
  size_t rest = c_index;
  for (size_t axis = shape.size(); axis-- > 0;) {
    stride /= shape[axis];
    index += rest % shape[axis] * stride;
    rest /= shape[axis];
  }
  return index;
}

}  // namespace

double HalfToDouble(uint16_t half) {
  const int exponent = half >> 10 & 31, fraction = half & 1023;
  double value =
      exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
  if (exponent == 31) value = fraction ? NAN : INFINITY;
  return half >> 15 ? -value : value;
}

bool ParseNpy(const std::string& file,
              const std::string& member,
              const std::vector<char>& bytes,
              NpyArray& array) {
  const Header header(file, member, bytes);
  const std::string dtype = header.Descr();
  if (dtype.size() > 1 && (dtype[1] == 'U' || dtype[1] == 'S')) return false;
  const Element element = ElementOf(dtype);
  if (element.bytes == 0)
    header.Fail("has type " + dtype +
                ", expected a numeric type (object arrays are not supported)");
  if (dtype[0] == '>' && element.bytes > 1)
    header.Fail("has type " + dtype + ", expected little-endian numbers");
  const std::vector<size_t> shape = header.Shape();
  const size_t count =
      CheckedCount(header, shape, element.bytes, bytes.size() - header.data_begin());
  const bool fortran = header.FortranOrder() && shape.size() > 1;
  const char* data = bytes.data() + header.data_begin();
  array.shape = shape;
  array.dtype = dtype;
  array.values.resize(count);
  for (size_t i = 0; i < count; ++i)
    array.values[i] = element.read(data + element.bytes * (fortran ? FortranIndex(shape, i) : i));
  return true;
}

std::string FormatNpy(const NpyArray& array) {
  const bool integers = array.dtype == "<i4";
  const std::string dtype = integers ? "<i4" : "<f4";
  std::string header = "{'descr': '" + dtype + "', 'fortran_order': False, 'shape': (";
  for (size_t extent : array.shape) header += std::to_string(extent) + ",";
  header += "), }";
  // The data begins at a multiple of 64 bytes, and the header ends with a newline.
  while ((10 + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::string bytes = std::string("\x93NUMPY\x01", 7) + '\0';
  bytes += char(header.size() & 255);
  bytes += char(header.size() >> 8);
  bytes += header;
  bytes.reserve(bytes.size() + 4 * array.size());
  for (double value : array.values) {
    const uint32_t bits =
        integers ? std::bit_cast<uint32_t>(int32_t(value)) : std::bit_cast<uint32_t>(float(value));
    bytes.append(reinterpret_cast<const char*>(&bits), sizeof(bits));
  }
  return bytes;
}

}  // namespace cosplat

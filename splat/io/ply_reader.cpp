#include "splat/io/ply_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

template <class T>
double Load(const char* p, bool big_endian) {
  std::array<char, sizeof(T)> bytes;
  std::copy_n(p, sizeof(T), bytes.begin());
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return double(std::bit_cast<T>(bytes));
}

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

constexpr size_t kLongestHeader = 1 << 20;  // programs put whole settings into comments

// Programs that edit point clouds (CloudCompare, 3dgsconverter) put these before splats'
// properties.
std::string WithoutPrefixes(std::string name) {
  for (const std::string prefix : {"scalar_", "scal_"})
    if (name.starts_with(prefix)) name.erase(0, prefix.size());
  return name;
}

// Longest name in the header, and longest quotation: a line may have thousands of characters.
constexpr size_t kLongestName = 80;
std::string PlyQuote(const std::string& text) {
  return "'" + (text.size() > kLongestName ? text.substr(0, kLongestName) + "..." : text) + "'";
}

}  // namespace

PlyReader::PlyReader(const std::string& path) : path_(path), bytes_(ReadUnpacked(path)) {
  bytes_.push_back('\0');  // terminates the last number of an ascii file
  ReadHeader();
}

bool PlyReader::Has(const std::string& element, const std::string& property) const {
  for (const Element& e : elements_)
    for (const Property& p : e.properties)
      if (e.name == element && p.name == property && !p.is_list) return true;
  return false;
}

double PlyReader::CommentNumber(const std::string& word, double fallback) const {
  const auto found = std::find_if(comments_.begin(), comments_.end(), [&](const std::string& c) {
    return c.starts_with(word + " ");
  });
  if (found == comments_.end()) return fallback;
  const std::string text = found->substr(word.size() + 1);
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !std::isfinite(number))
    throw Error(path_, "comment " + word, PlyQuote(text) + " is not a number");
  return number;
}

bool PlyReader::IsDouble(const std::string& name) const {
  return std::any_of(
      element_.properties.begin(), element_.properties.end(), [&](const Property& property) {
        return property.name == name && property.type.bytes == sizeof(double);
      });
}

void PlyReader::Enter(const std::string& element) {
  while (row_ < element_.count) Next();
  while (next_element_ < elements_.size()) {
    EnterNext();
    if (element_.name == element) return;
    while (row_ < element_.count) Next();
  }
  throw Error(path_, "has no element " + element);
}

void PlyReader::EnterNext() {
  element_ = elements_[next_element_++];
  row_ = 0;
  names_.clear();
  for (const Property& p : element_.properties)
    if (!p.is_list) names_.push_back(p.name);
  // Rejects impossible counts before allocating.
  const size_t left = bytes_.size() - at_;
  if (element_.count > left / std::max<size_t>(1, element_.properties.size()))
    Fail("the header says " + std::to_string(element_.count) + " of them, the file ends after " +
         std::to_string(left / MinRowBytes()));
}

size_t PlyReader::MinRowBytes() const {
  size_t bytes = 0;
  for (const Property& p : element_.properties)
    bytes += ascii_ ? 2 : (p.is_list ? p.count_type : p.type).bytes;
  return std::max<size_t>(1, bytes);
}

size_t PlyReader::BytesLeftOver() const {
  const bool lists = std::any_of(element_.properties.begin(),
                                 element_.properties.end(),
                                 [](const Property& p) { return p.is_list; });
  if (ascii_ || lists || next_element_ < elements_.size()) return 0;
  const size_t end = at_ + (element_.count - row_) * MinRowBytes();
  if (end >= bytes_.size() - 1) return 0;
  const size_t left = bytes_.size() - 1 - end;
  if (crlf_ && left > 2)
    throw Error(path_,
                Format("is {} bytes longer than its header says, whose lines end in CR LF: it was "
                       "converted as if it were text, copy it as binary (ftp, git)",
                       left));
  return left < MinRowBytes() ? 0 : left;
}

int PlyReader::Find(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? -1 : int(found - names_.begin());
}

int PlyReader::Require(const std::string& name) const {
  const int index = Find(name);
  if (index < 0) Fail("has no property " + name);
  return index;
}

void PlyReader::ReadHeader() {
  const std::string end = "end_header";
  for (int number = 0;; ++number) {
    const auto newline = std::find(bytes_.begin() + at_, bytes_.end(), '\n');
    if (newline == bytes_.end() || size_t(newline - bytes_.begin()) > kLongestHeader)
      throw Error(path_,
                  number == 0               ? "is not a PLY file"
                  : newline == bytes_.end() ? "ends inside the header"
                                            : "has a header of more than a megabyte");
    std::string line(bytes_.begin() + at_, newline);
    crlf_ = line.ends_with('\r');
    if (crlf_) line.pop_back();
    at_ = size_t(newline - bytes_.begin()) + 1;
    if (number == 0 && line != "ply") throw Error(path_, "is not a PLY file");
    if (line == end) break;
    if (number > 0) HeaderLine(line);
  }
  if (!format_seen_) throw Error(path_, "has no format line");
}

void PlyReader::HeaderLine(const std::string& line) {
  std::istringstream words(line);
  std::string word, name, type;
  words >> word;
  if (word == "format") {
    words >> name;
    if (name != "ascii" && name != "binary_little_endian" && name != "binary_big_endian")
      throw Error(path_,
                  "format",
                  PlyQuote(name) + " is none of ascii, binary_little_endian, binary_big_endian");
    ascii_ = name == "ascii";
    big_endian_ = name == "binary_big_endian";
    format_seen_ = true;
  } else if (word == "element") {
    Element element;
    long long count = -1;
    words >> element.name >> count;
    if (words.fail() || count < 0 || element.name.size() > kLongestName)
      throw Error(path_, "header", "cannot read " + PlyQuote(line));
    element.count = size_t(count);
    elements_.push_back(element);
  } else if (word == "property") {
    Property property;
    words >> type;
    property.is_list = type == "list";
    if (property.is_list) {
      words >> type;
      property.count_type = TypeOf(line, type);
      words >> type;
    }
    property.type = TypeOf(line, type);
    words >> property.name;
    if (words.fail() || elements_.empty() || property.name.size() > kLongestName)
      throw Error(path_, "header", "cannot read " + PlyQuote(line));
    property.name = WithoutPrefixes(property.name);
    elements_.back().properties.push_back(property);
  } else if (word == "comment") {
    std::getline(words >> std::ws, name);
    comments_.push_back(name);
  } else if (word != "obj_info" && !word.empty()) {
    throw Error(path_, "header", "cannot read " + PlyQuote(line));
  }
}

PlyReader::Type PlyReader::TypeOf(const std::string& line, const std::string& name) const {
  static const std::map<std::string, Type> kTypes{{"char", {1, Load<int8_t>}},
                                                  {"int8", {1, Load<int8_t>}},
                                                  {"uchar", {1, Load<uint8_t>}},
                                                  {"uint8", {1, Load<uint8_t>}},
                                                  {"short", {2, Load<int16_t>}},
                                                  {"int16", {2, Load<int16_t>}},
                                                  {"ushort", {2, Load<uint16_t>}},
                                                  {"uint16", {2, Load<uint16_t>}},
                                                  {"int", {4, Load<int32_t>}},
                                                  {"int32", {4, Load<int32_t>}},
                                                  {"uint", {4, Load<uint32_t>}},
                                                  {"uint32", {4, Load<uint32_t>}},
                                                  {"float", {4, Load<float>}},
                                                  {"float32", {4, Load<float>}},
                                                  {"double", {8, Load<double>}},
                                                  {"float64", {8, Load<double>}}};
  const auto found = kTypes.find(name);
  if (found == kTypes.end())
    throw Error(path_, "header", "unknown type " + PlyQuote(name) + " in " + PlyQuote(line));
  return found->second;
}

const std::vector<double>& PlyReader::Next() {
  ReadRow();
  ++row_;
  return values_;
}

void PlyReader::ReadRow() {
  values_.clear();
  for (const Property& p : element_.properties) {
    if (!p.is_list) {
      values_.push_back(ReadNumber(p.type, p));
      continue;
    }
    const double length = ReadNumber(p.count_type, p);
    if (!(length >= 0))
      throw Error(path_, element_.name + " " + std::to_string(row_), p.name + " has a bad length");
    for (double i = 0; i < length; ++i) ReadNumber(p.type, p);
  }
}

double PlyReader::ReadNumber(Type type, const Property& property) {
  return ascii_ ? ReadAscii(property) : ReadBinary(type, property);
}

double PlyReader::ReadBinary(Type type, const Property& property) {
  if (bytes_.size() - 1 - at_ < type.bytes)
    throw Error(path_,
                element_.name + " " + std::to_string(row_),
                "the file ends at " + property.name + " after " + std::to_string(row_) +
                    " of them, expected " + std::to_string(element_.count));
  const char* p = bytes_.data() + at_;
  at_ += type.bytes;
  return type.load(p, big_endian_);
}

double PlyReader::ReadAscii(const Property& property) {
  while (IsSpace(bytes_[at_])) ++at_;
  char* end = nullptr;
  const double value = std::strtod(bytes_.data() + at_, &end);
  const size_t next = size_t(end - bytes_.data());
  if (next == at_ || (!IsSpace(*end) && *end != '\0'))
    throw Error(
        path_,
        element_.name + " " + std::to_string(row_),
        property.name + (bytes_[at_] == '\0' ? " is missing, the file ends" : " is not a number"));
  at_ = next;
  return value;
}

void PlyReader::Fail(const std::string& property, const std::string& problem) const {
  throw Error(path_, element_.name + " " + std::to_string(row_ - 1) + ", " + property, problem);
}

void PlyReader::Fail(const std::string& problem) const {
  throw Error(path_, element_.name, problem);
}

}  // namespace cosplat

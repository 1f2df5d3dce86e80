#include "splat/io/ply_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>

#include "splat/base/error.h"
#include "splat/base/files.h"

namespace cosplat {
namespace {

template <class T>
double Load(const char* p) {
  T value;
  std::memcpy(&value, p, sizeof(T));
  return double(value);
}

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

// Of a name in the header, and of what a message quotes: a line may have thousands of characters.
constexpr size_t kLongestName = 80;
std::string PlyQuote(const std::string& text) {
  return "'" + (text.size() > kLongestName ? text.substr(0, kLongestName) + "..." : text) + "'";
}

}  // namespace

PlyReader::PlyReader(const std::string& path) : path_(path), bytes_(ReadFile(path)) {
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
  const auto found = comments_.lower_bound(word + " ");
  if (found == comments_.end() || !found->starts_with(word + " ")) return fallback;
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
        return property.name == name && property.type == Type::kDouble;
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
  // Every property takes at least one byte; rejects impossible counts before allocating.
  if (element_.count > (bytes_.size() - at_) / std::max<size_t>(1, element_.properties.size()))
    Fail("the file is too short for " + std::to_string(element_.count) + " of them");
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
    if (newline == bytes_.end() || newline - (bytes_.begin() + at_) > 4096)
      throw Error(path_, number == 0 ? "is not a PLY file" : "ends inside the header");
    std::string line(bytes_.begin() + at_, newline);
    if (line.ends_with('\r')) line.pop_back();
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
    if (name != "ascii" && name != "binary_little_endian")
      throw Error(path_,
                  "format",
                  PlyQuote(name) + " is not supported, expected ascii or binary_little_endian");
    ascii_ = name == "ascii";
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
    elements_.back().properties.push_back(property);
  } else if (word == "comment") {
    std::getline(words >> std::ws, name);
    comments_.insert(name);
  } else if (word != "obj_info" && !word.empty()) {
    throw Error(path_, "header", "cannot read " + PlyQuote(line));
  }
}

PlyReader::Type PlyReader::TypeOf(const std::string& line, const std::string& name) const {
  static const std::map<std::string, Type> kTypes{{"char", Type::kInt8},
                                                  {"int8", Type::kInt8},
                                                  {"uchar", Type::kUint8},
                                                  {"uint8", Type::kUint8},
                                                  {"short", Type::kInt16},
                                                  {"int16", Type::kInt16},
                                                  {"ushort", Type::kUint16},
                                                  {"uint16", Type::kUint16},
                                                  {"int", Type::kInt32},
                                                  {"int32", Type::kInt32},
                                                  {"uint", Type::kUint32},
                                                  {"uint32", Type::kUint32},
                                                  {"float", Type::kFloat},
                                                  {"float32", Type::kFloat},
                                                  {"double", Type::kDouble},
                                                  {"float64", Type::kDouble}};
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
  constexpr size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  const size_t size = kSizes[size_t(type)];
  if (bytes_.size() - 1 - at_ < size)
    throw Error(path_,
                element_.name + " " + std::to_string(row_),
                "the file ends at " + property.name + ", expected " +
                    std::to_string(element_.count) + " of them");
  const char* p = bytes_.data() + at_;
  at_ += size;
  switch (type) {
    case Type::kInt8:
      return Load<int8_t>(p);
    case Type::kUint8:
      return Load<uint8_t>(p);
    case Type::kInt16:
      return Load<int16_t>(p);
    case Type::kUint16:
      return Load<uint16_t>(p);
    case Type::kInt32:
      return Load<int32_t>(p);
    case Type::kUint32:
      return Load<uint32_t>(p);
    case Type::kFloat:
      return Load<float>(p);
    case Type::kDouble:
      return Load<double>(p);
  }
  return 0;  // unreachable: all types are listed
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

// Reads the elements of a PLY file with any properties: ascii or binary of either byte order, as it
// is or packed by gzip.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosplat {

// Returns the rows of an element one by one. Elements must be entered in file order; those in
// between are skipped, and those after the last are never read. Every problem is an Error that
// names the file and the header line or row.
class PlyReader {
 public:
  // Reads the header.
  explicit PlyReader(const std::string& path);

  // Whether the header has this property, for an element anywhere in the file.
  bool Has(const std::string& element, const std::string& property) const;
  // The header's comments, in order.
  const std::vector<std::string>& comments() const { return comments_; }
  // The number that follows this word in a comment; `fallback` if there is no such comment. Throws
  // Error if it is no finite number.
  double CommentNumber(const std::string& word, double fallback) const;
  // Whether the current element's property is stored as a double.
  bool IsDouble(const std::string& name) const;
  // Makes this the current element. Throws Error if there is none after the current one, or if the
  // file is too short for its count.
  void Enter(const std::string& element);

  size_t count() const { return element_.count; }
  // Names of the current element's scalar properties in file order; lists are skipped.
  const std::vector<std::string>& properties() const { return names_; }
  // Index into properties(). If it is absent, Require throws Error naming it and Find returns -1.
  int Require(const std::string& name) const;
  int Find(const std::string& name) const;

  // The next row's properties, in the order of properties(). May hold NaN.
  const std::vector<double>& Next();
  // Throws Error naming the current row and the property.
  [[noreturn]] void Fail(const std::string& property, const std::string& problem) const;
  // Throws Error naming the element.
  [[noreturn]] void Fail(const std::string& problem) const;
  // Bytes behind the current element, if it is the last of a binary file and has no lists; 0 if
  // they are less than a row. Throws Error where line endings were converted, which changes
  // numbers.
  size_t BytesLeftOver() const;
  const std::string& path() const { return path_; }

 private:
  struct Type {
    size_t bytes = 0;
    double (*load)(const char*, bool big_endian) = nullptr;
  };
  struct Property {
    std::string name;
    Type type;
    bool is_list = false;
    Type count_type;  // of a list
  };
  struct Element {
    std::string name;
    size_t count = 0;
    std::vector<Property> properties;
  };

  void ReadHeader();
  void HeaderLine(const std::string& line);
  Type TypeOf(const std::string& line, const std::string& name) const;
  // Enters the next element of the file.
  void EnterNext();
  void ReadRow();
  double ReadNumber(Type type, const Property& property);
  double ReadBinary(Type type, const Property& property);
  size_t MinRowBytes() const;
  double ReadAscii(const Property& property);

  std::string path_;
  std::vector<char> bytes_;
  size_t at_ = 0;
  bool ascii_ = false, big_endian_ = false;
  bool format_seen_ = false;
  bool crlf_ = false;  // the header's lines end so
  std::vector<std::string> comments_;
  std::vector<Element> elements_;
  size_t next_element_ = 0;  // into elements_
  Element element_;          // the current one
  size_t row_ = 0;           // next row of element_
  std::vector<std::string> names_;
  std::vector<double> values_;
};

}  // namespace cosplat

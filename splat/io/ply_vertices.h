// The vertices of a PLY file, whatever their properties: ascii or binary little-endian.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosplat {

// Gives one vertex after the other. Elements before `vertex` are skipped over, those after it never
// looked at. Every problem is an Error that names the file and the header line or vertex.
class PlyVertexReader {
 public:
  explicit PlyVertexReader(const std::string& path);

  size_t count() const { return count_; }
  // Names of the vertices' scalar properties in file order; lists are skipped.
  const std::vector<std::string>& properties() const { return names_; }
  // Index into properties(); Error naming it when absent, or -1 where it is optional.
  int Require(const std::string& name) const;
  int Find(const std::string& name) const;

  // The next vertex's properties, in the order of properties(). May hold NaN.
  const std::vector<double>& Next();
  // Error naming the current vertex and the property.
  [[noreturn]] void Fail(const std::string& property, const std::string& problem) const;
  const std::string& path() const { return path_; }

 private:
  enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
  struct Property {
    std::string name;
    Type type = Type::kFloat;
    bool is_list = false;
    Type count_type = Type::kUint8;
  };
  struct Element {
    std::string name;
    size_t count = 0;
    std::vector<Property> properties;
  };

  void ReadHeader();
  void HeaderLine(const std::string& line, std::vector<Element>& elements);
  Type TypeOf(const std::string& line, const std::string& name) const;
  void ReadRow(const Element& element);
  double ReadNumber(Type type, const Property& property);
  double ReadBinary(Type type, const Property& property);
  double ReadAscii(const Property& property);

  std::string path_;
  std::vector<char> bytes_;
  size_t at_ = 0;
  bool ascii_ = false;
  bool format_seen_ = false;
  Element vertex_;
  size_t count_ = 0;
  size_t row_ = 0;       // of the element being read
  std::string element_;  // its name, for messages
  size_t element_count_ = 0;
  std::vector<std::string> names_;
  std::vector<double> values_;
};

}  // namespace cosplat

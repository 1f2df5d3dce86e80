// JSON with errors that name file, field and value. Thin helpers over nlohmann::json.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace cosplat {

using Json = nlohmann::json;

// Parses a file; Error names the file and the line and column of a syntax error.
Json ReadJson(const std::string& path);

// Parses text; Error names `source` and the line and column of a syntax error. NaN and Infinity,
// which Python writes, become null.
Json ParseJson(const std::string& source, std::string text);

// A value together with its origin. Every accessor throws Error(file, "a.b[3].c", found/expected).
class JsonField {
 public:
  JsonField(const std::string& file, const Json& value) : file_(file), value_(&value) {}
  // Keeps the value, as do the fields within it: JsonField(path, ReadJson(path)).
  JsonField(const std::string& file, Json&& value)
      : file_(file), kept_(std::make_shared<const Json>(std::move(value))), value_(kept_.get()) {}
  bool Has(const std::string& key) const;
  JsonField operator[](const std::string& key) const;  // Error when absent
  JsonField operator[](size_t index) const;
  size_t size() const;    // of an array; Error otherwise
  double Number() const;  // finite; Error on a NaN, null, string, ...
  int Integer() const;
  int Integer(int min, int max) const;
  std::string String() const;
  // An array of `count` finite numbers (any length when count is 0); nested arrays are flattened.
  std::vector<float> Numbers(size_t count = 0) const;
  // Like Numbers, but NaN and infinity (null after ReadJson) are returned as NaN, for values that,
  // if invalid, should cost only a single frame.
  std::vector<double> NumbersOrNan(size_t count = 0) const;
  double NumberOr(const std::string& key, double fallback) const;
  const std::string& file() const { return file_; }
  const std::string& path() const { return path_; }
  const Json& raw() const { return *value_; }
  [[noreturn]] void Fail(const std::string& problem) const;  // throws Error of this field

 private:
  std::string file_;
  std::string path_;
  std::shared_ptr<const Json> kept_;  // what value_ is in; null: the caller's
  const Json* value_;

  JsonField Within(const Json& value, const std::string& path) const;
};

}  // namespace cosplat

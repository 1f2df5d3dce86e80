#include "splat/base/json.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

// Python writes NaN, Infinity and -Infinity, which are not valid JSON. They become null, so that an
// invalid number costs only its frame (its field is named) and not the whole file.
void ReplaceNonFiniteTokens(std::string& text) {
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    if (in_string && text[i] == '\\') {
      ++i;
    } else if (text[i] == '"') {
      in_string = !in_string;
    } else if (!in_string && (text[i] == 'N' || text[i] == 'I')) {
      const std::string token = text[i] == 'N' ? "NaN" : "Infinity";
      if (text.compare(i, token.size(), token) != 0) continue;
      const size_t begin = i > 0 && text[i - 1] == '-' ? i - 1 : i;
      text.replace(begin, i + token.size() - begin, "null");
      i = begin + 3;
    }
  }
}

std::string LineAndColumn(const std::string& text, size_t offset) {
  const auto end = text.begin() + std::min(offset, text.size());
  const auto line = 1 + std::count(text.begin(), end, '\n');
  const auto newline = std::find(std::make_reverse_iterator(end), text.rend(), '\n');
  const auto column = 1 + (end - newline.base());
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

// A value as shown in an error message: short and on one line.
std::string Shown(const Json& value) {
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  if (value.is_object()) return "an object";
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

// `levels`: maximum nesting of arrays, so that a malicious file cannot overflow the stack.
void Flatten(const JsonField& field, bool null_is_nan, int levels, std::vector<double>& out) {
  if (!field.raw().is_array() || levels == 0) {
    const bool nan = null_is_nan && field.raw().is_null();
    out.push_back(nan ? std::numeric_limits<double>::quiet_NaN() : field.Number());
    return;
  }
  for (size_t i = 0; i < field.raw().size(); ++i) Flatten(field[i], null_is_nan, levels - 1, out);
}

std::vector<double> NumbersOf(const JsonField& field, size_t count, bool null_is_nan) {
  field.size();  // must be an array
  constexpr int kMaxLevels = 4;
  std::vector<double> numbers;
  Flatten(field, null_is_nan, kMaxLevels, numbers);
  if (count != 0 && numbers.size() != count)
    field.Fail(Format("found {} numbers, expected {}", numbers.size(), count));
  return numbers;
}

}  // namespace

Json ReadJson(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return ParseJson(path, {bytes.begin(), bytes.end()});
}

Json ParseJson(const std::string& source, std::string text) {
  ReplaceNonFiniteTokens(text);
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const size_t offset = error.byte > 0 ? error.byte - 1 : 0;
    const std::string found = offset < text.size() ? "unexpected text" : "it ends too early";
    throw Error(source, LineAndColumn(text, offset), "not valid JSON: " + found);
  } catch (const Json::exception& error) {  // a number outside double's range
    throw Error(source, std::string("not valid JSON: ") + error.what());
  }
}

void JsonField::Fail(const std::string& problem) const { throw Error(file_, path_, problem); }

JsonField JsonField::Within(const Json& value, const std::string& path) const {
  JsonField field(file_, value);
  field.path_ = path;
  field.kept_ = kept_;
  return field;
}

bool JsonField::Has(const std::string& key) const {
  return value_->is_object() && value_->contains(key);
}

JsonField JsonField::operator[](const std::string& key) const {
  if (!value_->is_object()) Fail("found " + Shown(*value_) + ", expected an object with " + key);
  const auto found = value_->find(key);
  const std::string path = path_.empty() ? key : path_ + "." + key;
  if (found == value_->end()) throw Error(file_, path, "is missing");
  return Within(*found, path);
}

JsonField JsonField::operator[](size_t index) const {
  const std::string path = path_ + "[" + std::to_string(index) + "]";
  if (index >= size()) throw Error(file_, path, Format("is missing, the array has {}", size()));
  return Within((*value_)[index], path);
}

size_t JsonField::size() const {
  if (!value_->is_array()) Fail("found " + Shown(*value_) + ", expected an array");
  return value_->size();
}

double JsonField::Number() const {
  if (!value_->is_number() || !std::isfinite(value_->get<double>()))
    Fail("found " + Shown(*value_) + ", expected a finite number");
  return value_->get<double>();
}

int JsonField::Integer() const {
  const double number = Number();
  if (number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max())
    Fail("found " + Shown(*value_) + ", expected an integer");
  return int(number);
}

int JsonField::Integer(int min, int max) const {
  const int value = Integer();
  if (value < min || value > max) Fail(Format("is {}, expected {} to {}", value, min, max));
  return value;
}

std::string JsonField::String() const {
  if (!value_->is_string()) Fail("found " + Shown(*value_) + ", expected a string");
  return value_->get<std::string>();
}

std::vector<float> JsonField::Numbers(size_t count) const {
  std::vector<float> numbers;
  for (double number : NumbersOf(*this, count, false)) {
    if (std::abs(number) > std::numeric_limits<float>::max())
      Fail("holds " + std::to_string(number) + ", too large");
    numbers.push_back(float(number));
  }
  return numbers;
}

std::vector<double> JsonField::NumbersOrNan(size_t count) const {
  return NumbersOf(*this, count, true);
}

double JsonField::NumberOr(const std::string& key, double fallback) const {
  return Has(key) ? (*this)[key].Number() : fallback;
}

}  // namespace cosplat

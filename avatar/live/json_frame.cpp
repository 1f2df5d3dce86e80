#include "avatar/live/json_frame.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "avatar/live/guard.h"
#include "avatar/live/unused_input.h"
#include "splat/base/error.h"
#include "splat/base/json.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr double kMaxSeconds = 9e9;  // fits into 64 bits as nanoseconds
constexpr long kMaxArrays = 64;      // thousands parse five times slower than numbers of equal size

std::vector<float> NumbersOf(const JsonField& field, size_t count) {
  std::vector<float> numbers = field.Numbers(count);
  for (size_t i = 0; i < numbers.size(); ++i)
    if (std::abs(numbers[i]) > kMaxParameter)
      throw Error(field.file(),
                  field.path() + "[" + std::to_string(i) + "]",
                  "is " + std::to_string(numbers[i]) + ", expected -100 to 100");
  return numbers;
}

void ReadVector(const JsonField& field, std::array<float, 3>& out) {
  const std::vector<float> numbers = NumbersOf(field, 3);
  std::copy(numbers.begin(), numbers.end(), out.begin());
}

// Three numbers rotate both eyes equally; six are the left eye and the right one.
void ReadEyes(const JsonField& field, FlameParams& params) {
  const std::vector<float> numbers = NumbersOf(field, field.size() == 3 ? 3 : 6);
  std::copy_n(numbers.begin(), 3, params.pose[3].begin());
  std::copy_n(numbers.end() - 3, 3, params.pose[4].begin());
}

uint64_t SequenceOf(const JsonField& field) {
  if (!field.raw().is_number_unsigned()) field.Fail("is not a non-negative integer");
  return field.raw().get<uint64_t>();
}

double TimeOf(const JsonField& field) {
  const double time = field.Number();
  if (std::abs(time) > kMaxSeconds) field.Fail("is out of range: at most 9e9 seconds");
  return time;
}

void ReadScores(const JsonField& field, JsonFrame& frame) {
  if (!field.raw().is_object()) field.Fail("is not an object of names and scores");
  BlendshapeScores& scores = frame.blendshapes.emplace();
  for (const auto& [name, value] : field.raw().items()) {
    if (value.is_number() && std::abs(value.get<double>()) <= kMaxScore)
      scores[name] = value.get<float>();
    else
      frame.dropped.push_back(name);
  }
}

// Scores determine expression, jaw and eyes.
void CheckScoresAlone(const JsonField& object) {
  if (!object.Has("blendshapes")) return;
  for (const char* field : {"expression", "jaw", "eyes"})
    if (object.Has(field))
      throw Error(
          object.file(), field, "is given beside blendshapes, which determine it: give either");
}

void ReadMember(const JsonField& json, const std::string& name, JsonFrame& frame) {
  FlameParams& p = frame.params;
  if (name == "seq") return void(frame.sequence = SequenceOf(json[name]));
  if (name == "time") return void(frame.time = TimeOf(json[name]));
  if (name == "expression") return void(p.expression = NumbersOf(json[name], 0));
  if (name == "pose") return ReadVector(json[name], p.pose[0]);
  if (name == "neck") return ReadVector(json[name], p.pose[1]);
  if (name == "jaw") return ReadVector(json[name], p.pose[2]);
  if (name == "eyes") return ReadEyes(json[name], p);
  if (name == "translation") return ReadVector(json[name], p.translation);
  if (name == "blendshapes") return ReadScores(json[name], frame);
  throw Error(json.file(), PrintableName(name), "is not a field of a frame");
}

void AppendNumbers(const char* name, const float* begin, size_t count, std::string& line) {
  line += std::string(", \"") + name + "\": [";
  for (size_t i = 0; i < count; ++i) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof(text), begin[i]).ptr;
    line.append(i ? ", " : "").append(text, end);
  }
  line += "]";
}

void AppendScores(const BlendshapeScores& scores, std::string& line) {
  line += ", \"blendshapes\": " + Json(scores).dump();
}

}  // namespace

JsonFrame ParseJsonFrame(const std::string& source, const std::string& line) {
  const auto arrays = std::count(line.begin(), line.end(), '[');
  if (arrays + std::count(line.begin(), line.end(), '{') > kMaxArrays)
    throw Error(source, "", Format("holds more than {} arrays and objects", kMaxArrays));
  const JsonField object(source, ParseJson(source, line));
  JsonFrame frame;
  frame.sequence = SequenceOf(object["seq"]);  // also throws if it is not an object
  for (const auto& [name, value] : object.raw().items()) ReadMember(object, name, frame);
  CheckScoresAlone(object);
  return frame;
}

std::string WriteJsonFrame(const JsonFrame& frame) {
  std::string line = "{\"seq\": " + std::to_string(frame.sequence);
  if (frame.time) {
    char text[40];
    line += ", \"time\": ";
    line.append(text, std::to_chars(text, text + sizeof(text), *frame.time).ptr);
  }
  const FlameParams& p = frame.params;
  std::array<float, 6> eyes;
  std::copy(p.pose[3].begin(), p.pose[3].end(), eyes.begin());
  std::copy(p.pose[4].begin(), p.pose[4].end(), eyes.begin() + 3);
  AppendNumbers("pose", p.pose[0].data(), 3, line);
  AppendNumbers("neck", p.pose[1].data(), 3, line);
  if (frame.blendshapes) {
    AppendScores(*frame.blendshapes, line);
  } else {
    AppendNumbers("expression", p.expression.data(), p.expression.size(), line);
    AppendNumbers("jaw", p.pose[2].data(), 3, line);
    AppendNumbers("eyes", eyes.data(), 6, line);
  }
  AppendNumbers("translation", p.translation.data(), 3, line);
  return line + "}";
}

}  // namespace cosplat

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/io/colmap_model.h"

namespace cosplat::colmap {
namespace {

constexpr std::string_view kCountOfImages = "# Number of images: ";

// The lines of a file, without comments, as streams of words.
class Lines {
 public:
  explicit Lines(const std::string& path) : path_(path) {
    const std::vector<char> bytes = ReadFile(path);
    std::string text(bytes.begin(), bytes.end());
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // of editors on Windows
    text_.str(std::move(text));
  }

  // The next line that is neither a comment nor blank; false at the end.
  bool NextRecord() {
    while (Next()) {
      if (line_.starts_with(kCountOfImages))
        stated_ = std::atol(line_.c_str() + kCountOfImages.size());
      if (line_.find_first_not_of(" \t\r") != std::string::npos && line_[0] != '#') return true;
    }
    return false;
  }

  // Skips an image's second line: its observations, numbers in threes, or nothing. Some programs
  // leave it out: an image has nine numbers and a name.
  void SkipObservations() {
    constexpr size_t kNumbers = 9;
    const auto before = text_.tellg();
    if (!Next()) return;
    std::string word;
    size_t words = 0;
    bool is_image = false;
    for (; words < kNumbers + 2 && !is_image && words_ >> word; ++words)
      is_image = words == kNumbers && !IsNumber(word);
    if (!is_image && words != kNumbers + 1) return;
    text_.clear();
    text_.seekg(before);
    --number_;
  }

  // The count that images.txt states in a comment; 0 if it does not.
  size_t stated() const { return stated_ > 0 ? size_t(stated_) : 0; }

  // std::stod rather than >>, which does not parse "nan": NaN must be reported by name.
  double Number(const char* what) {
    std::string word;
    size_t used = 0;
    double value = 0;
    words_ >> word;
    try {
      value = std::stod(word, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (word.empty() || used != word.size()) Fail(word, what);
    return value;
  }

  int64_t Integer(const char* what) {
    const double value = Number(what);
    if (!(value >= -9e15 && value <= 9e15) || value != double(int64_t(value)))
      Fail(std::to_string(value), what);
    return int64_t(value);
  }

  std::string Word(const char* what) {
    std::string word;
    if (!(words_ >> word)) Fail("", what);
    return word;
  }

  // The rest of the line, since names may contain spaces.
  std::string Rest(const char* what) {
    std::string rest;
    std::getline(words_ >> std::ws, rest);
    while (!rest.empty() && (rest.back() == '\r' || rest.back() == ' ')) rest.pop_back();
    if (rest.empty()) Fail("", what);
    return rest;
  }

  bool AtEnd() { return (words_ >> std::ws).eof(); }
  std::string Field() const { return "line " + std::to_string(number_); }

 private:
  bool Next() {
    if (!std::getline(text_, line_)) return false;
    ++number_;
    words_.clear();
    words_.str(line_);
    return true;
  }

  static bool IsNumber(const std::string& word) {
    char* end = nullptr;
    std::strtod(word.c_str(), &end);
    return *end == '\0';
  }

  [[noreturn]] void Fail(const std::string& found, const char* what) const {
    throw Error(path_,
                Field(),
                (found.empty() ? "the line ends" : "found '" + found + "'") + ", expected " + what);
  }

  std::string path_;
  std::istringstream text_;
  std::string line_;
  std::istringstream words_;
  int number_ = 0;
  long stated_ = 0;
};

void ReadCamerasText(const std::string& path, ColmapModel& model) {
  Lines in(path);
  while (in.NextRecord()) {
    const uint32_t id = uint32_t(in.Integer("a camera id"));
    const std::string kind = in.Word("a camera model");
    const int64_t width = in.Integer("an image width");
    const int64_t height = in.Integer("an image height");
    std::vector<double> params;
    while (!in.AtEnd()) params.push_back(in.Number("a camera parameter"));
    model.cameras[id] = MakeColmapCamera(path, in.Field(), kind, {width, height}, params);
  }
}

void ReadImagesText(const std::string& path, ColmapModel& model) {
  Lines in(path);
  while (in.NextRecord()) {
    ColmapImage image;
    in.Integer("an image id");
    for (double& q : image.rotation) q = in.Number("a rotation");
    for (double& t : image.translation) t = in.Number("a translation");
    image.camera_id = uint32_t(in.Integer("a camera id"));
    image.name = in.Rest("an image name");
    model.images.push_back(std::move(image));
    in.SkipObservations();
  }
  if (in.stated() != 0 && in.stated() != model.images.size())
    model.notes.push_back(Format(
        "{} says that it has {} images, and has {}", path, in.stated(), model.images.size()));
}

void ReadPointsText(const std::string& path, ColmapModel& model) {
  Lines in(path);
  MeanError mean;
  while (in.NextRecord()) {
    in.Integer("a point id");
    for (int k = 0; k < 3; ++k) model.points.push_back(in.Number("a position"));
    for (int k = 0; k < 3; ++k) {
      const int64_t color = in.Integer("a colour");
      if (color < 0 || color > 255)
        throw Error(path, in.Field(), "colour " + std::to_string(color) + " is not in 0..255");
      model.point_colors.push_back(uint8_t(color));
    }
    if (!in.AtEnd()) mean.Add(in.Number("an error"));
  }
  model.mean_error = mean.Mean();
}

}  // namespace

void ReadText(const std::string& folder, ColmapModel& model) {
  ReadCamerasText(folder + "/cameras.txt", model);
  ReadImagesText(folder + "/images.txt", model);
  const std::string points = folder + "/points3D.txt";
  if (std::filesystem::exists(points)) ReadPointsText(points, model);
}

}  // namespace cosplat::colmap

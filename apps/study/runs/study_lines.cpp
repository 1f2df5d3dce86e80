#include "apps/study/runs/study_lines.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

std::vector<std::string> StringsOf(const JsonField& array) {
  std::vector<std::string> texts;
  for (size_t i = 0; i < array.size(); ++i) texts.push_back(array[i].String());
  return texts;
}

StudyLine FromJson(const JsonField& json) {
  StudyLine line;
  line.data = json["data"].String();
  line.name = json["name"].String();
  line.label = json["label"].String();
  line.groups = StringsOf(json["groups"]);
  line.minus = StringsOf(json["minus"]);
  line.seed = json["seed"].Integer();
  line.command = json["command"].String();
  line.version = json["version"].String();
  line.cpu = json["cpu"].String();
  const JsonField checkpoints = json["checkpoints"];
  for (size_t i = 0; i < checkpoints.size(); ++i) {
    const JsonField checkpoint = checkpoints[i];
    StudyFigures figures;
    for (const auto& [key, value] : checkpoint.raw().items())
      figures[key] = checkpoint[key].Number();
    checkpoint["iterations"].Integer();
    line.checkpoints.push_back(std::move(figures));
  }
  if (line.checkpoints.empty()) throw Error(json.file(), checkpoints.path(), "has no entry");
  return line;
}

std::string ToText(const StudyLine& line) {
  nlohmann::ordered_json json{{"data", line.data},
                              {"name", line.name},
                              {"label", line.label},
                              {"groups", line.groups},
                              {"minus", line.minus},
                              {"seed", line.seed},
                              {"command", line.command},
                              {"version", line.version},
                              {"cpu", line.cpu}};
  json["checkpoints"] = line.checkpoints;
  return json.dump() + "\n";
}

void ReadFileInto(const std::string& path, StudyLines& all) {
  const std::vector<char> bytes = ReadFile(path);
  auto begin = bytes.begin();
  for (int number = 1;; ++number) {
    const auto end = std::find(begin, bytes.end(), '\n');
    if (end == bytes.end()) return;
    const std::string where = path + ", line " + std::to_string(number);
    const Json json = Json::parse(begin, end, nullptr, false);
    if (json.is_discarded()) throw Error(where, "is not valid JSON");
    StudyLine line = FromJson(JsonField(where, json));
    const auto same = std::find_if(all.lines.begin(), all.lines.end(), [&](const StudyLine& other) {
      return other.Id() == line.Id();
    });
    if (same == all.lines.end()) {
      all.lines.push_back(std::move(line));
    } else {
      all.replaced.push_back(line.Id());
      *same = std::move(line);
    }
    begin = end + 1;
  }
}

// On a nearly full disk, write may accept part of a text before it fails.
bool WriteWhole(int file, const std::string& text) {
  for (size_t done = 0; done < text.size();) {
    const ssize_t written = write(file, text.data() + done, text.size() - done);
    if (written <= 0) return false;
    done += size_t(written);
  }
  return true;
}

}  // namespace

std::string StudyLine::Id() const { return data + "/" + name + "/" + std::to_string(seed); }

StudyLines ReadStudyLines(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".jsonl") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  StudyLines all;
  for (const std::string& file : files) ReadFileInto(file, all);
  return all;
}

void WritePublished(const std::string& folder, const std::vector<StudyLine>& lines) {
  MakeDirectories(folder);
  std::string text;
  for (const StudyLine& line : lines) text += ToText(line);
  WriteFileAtomically(folder + "/published.jsonl", text);
}

StudyLog::StudyLog(const std::string& folder, const std::string& name)
    : path_(folder + "/" + name) {
  MakeDirectories(folder);
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) throw Error(path_, std::string("cannot be written: ") + std::strerror(errno));
  if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
    close(file_);
    throw Error(path_, "another study is writing to it");
  }
  const std::vector<char> bytes = ReadFile(path_);
  const auto end = std::find(bytes.rbegin(), bytes.rend(), '\n');
  if (ftruncate(file_, bytes.rend() - end) != 0)
    throw Error(path_, std::string("cannot be cut: ") + std::strerror(errno));
}

StudyLog::~StudyLog() { close(file_); }

void StudyLog::Append(const StudyLine& line) {
  const off_t end = lseek(file_, 0, SEEK_END);
  if (WriteWhole(file_, ToText(line)) && fsync(file_) == 0) return;
  std::string problem = std::string("write failed: ") + std::strerror(errno);
  // The partial line would corrupt the next one.
  if (ftruncate(file_, end) != 0) problem += "; the line that was begun could not be removed";
  throw Error(path_, problem);
}

}  // namespace cosplat

// The finished runs of a study, one JSON line each: what `cosplat study` measured, and with which
// command. Lines of several files add up.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace cosplat {

// By name: "iterations", "PSNR", "gaussians", ... docs/study.md lists them.
using StudyFigures = std::map<std::string, double>;

struct StudyLine {
  std::string data, name, label;
  std::vector<std::string> groups, minus;
  int seed = 0;
  std::string command, version, cpu;
  std::vector<StudyFigures> checkpoints;  // by iterations; the last is the finished model

  std::string Id() const;  // as StudyRun's
};

struct StudyLines {
  std::vector<StudyLine> lines;       // one per Id, in the order of their first appearance
  std::vector<std::string> replaced;  // Ids of which a later line took the place of an earlier
};

// Of every *.jsonl in the folder, by name. A last line without its end is of a study that was cut
// short and is left out. Throws Error naming file, line and field of a line that is no good.
StudyLines ReadStudyLines(const std::string& folder);

// Adds lines to <folder>/runs.jsonl, each whole and on the disk or not at all. What a study that
// was cut short left of a line is removed. Throws Error when another study writes to the folder.
class StudyLog {
 public:
  explicit StudyLog(const std::string& folder);
  ~StudyLog();
  StudyLog(const StudyLog&) = delete;
  StudyLog& operator=(const StudyLog&) = delete;
  void Append(const StudyLine& line);

 private:
  std::string path_;
  int file_;
};

}  // namespace cosplat

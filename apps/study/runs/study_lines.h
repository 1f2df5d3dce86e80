// The finished runs of a study, one JSON line each: the results of `cosplat-study` and the command
// that produced them. Lines of several files are combined.
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
  std::vector<StudyFigures> checkpoints;  // by iterations; the last one is the finished model

  std::string Id() const;  // as StudyRun's
  // Somebody else's figures, which the list states: `name` is their system's.
  bool published() const { return command.empty(); }
};

struct StudyLines {
  std::vector<StudyLine> lines;       // one per Id, in the order of their first appearance
  std::vector<std::string> replaced;  // Ids for which a later line replaced an earlier one
};

// Reads every *.jsonl in the folder, in order of name. An unterminated last line belongs to an
// interrupted study and is ignored. Throws Error naming file, line and field of an invalid line.
StudyLines ReadStudyLines(const std::string& folder);

// Writes what the lists' data sets state as published, in place of what an earlier list stated.
void WritePublished(const std::string& folder, const std::vector<StudyLine>& lines);

// Appends lines to a file of the folder, each atomically and flushed to disk. Removes a partial
// line that an interrupted study left. Throws Error if another study is writing to it.
class StudyLog {
 public:
  explicit StudyLog(const std::string& folder, const std::string& name = "runs.jsonl");
  ~StudyLog();
  StudyLog(const StudyLog&) = delete;
  StudyLog& operator=(const StudyLog&) = delete;
  void Append(const StudyLine& line);

 private:
  std::string path_;
  int file_;
};

}  // namespace cosplat

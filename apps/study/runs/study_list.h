// What `cosplat study` is to run: settings crossed with data sets and seeds.
//
// list.json -> ReadStudyList -> StudyRun -> study_runner.h. docs/study.md describes the file field
// by field; arguments are the trainers' own and are only handed on.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cosplat {

struct StudyData {
  std::string name;
  bool avatar = false;
  std::string source;  // below the data folder; of a made head below the study's folder
  std::string flame;   // avatars: the model file, below the same folder
  std::optional<std::vector<std::string>> make_head;  // arguments that film the source
  std::vector<std::string> arguments;                 // of the trainer
  std::vector<int> checkpoints;                       // steps to evaluate at, beside the last
  std::vector<int> counts;                            // what {count} stands for
  std::vector<int> seeds;
};

struct StudyRun {
  StudyData data;
  std::string name;                 // told apart by it, together with data and seed
  std::string label;                // of the curve that it is a point of
  std::vector<std::string> groups;  // the charts that it is on
  std::vector<std::string> minus;   // names of settings that it is compared with, seed by seed
  std::vector<std::string> arguments;
  std::vector<int> seeds;  // of the data's, those that it is run with; empty: all
  int seed = 0;

  std::string Id() const;  // "fox-8/dcsh/0"

  // Arguments of the `cosplat` that trains it. `data_folder` and `out` end in '/' or are empty.
  std::vector<std::string> TrainArguments(const std::string& data_folder,
                                          const std::string& out,
                                          const std::string& model) const;
  // The same as one shell line that holds on any machine: paths as the list has them.
  std::string Command() const;
};

// In the order in which they are to run: by seed, data, setting, so that a study that is cut short
// has a seed of everything first. Throws Error naming field and value.
std::vector<StudyRun> ReadStudyList(const std::string& path);

// A shell line of these arguments, quoted where needed.
std::string ShellLine(const std::vector<std::string>& arguments);

}  // namespace cosplat

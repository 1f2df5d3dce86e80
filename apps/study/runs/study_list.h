// The runs of a `cosplat-study`: settings crossed with data sets and seeds.
//
// list.json -> ReadStudyList -> StudyRun -> study_runner.h. docs/study.md describes every field of
// the file; arguments are those of the trainers and are passed on unchanged.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace cosplat {

struct StudyData {
  std::string name;
  bool avatar = false;
  std::string source;  // below the data folder, or below the study's folder for a generated head
  std::string flame;   // avatars: the model file, below the same folder
  std::optional<std::vector<std::string>> make_head;  // make-head arguments for `source`
  std::vector<std::string> arguments;                 // of the trainer
  std::vector<int> checkpoints;  // steps to evaluate at, in addition to the last
  std::vector<int> counts;       // values of {count}
  std::vector<int> seeds;
  // What others have published for this data, by system: figures as study lines have them.
  std::map<std::string, std::map<std::string, double>> published;
};

struct StudyRun {
  StudyData data;
  std::string name;                 // identifies the run, together with data and seed
  std::string label;                // name of the curve that the run is a point of
  std::vector<std::string> groups;  // the charts that show it
  std::vector<std::string> minus;   // names of the settings to compare with, seed by seed
  std::vector<std::string> arguments;
  std::vector<int> seeds;  // subset of the data's seeds to run with; empty: all
  int seed = 0;

  std::string Id() const;  // "fox-8/dcsh/0"

  // Arguments of the `cosplat` command that trains the run. `data_folder` and `out` end in '/' or
  // are empty.
  std::vector<std::string> TrainArguments(const std::string& data_folder,
                                          const std::string& out,
                                          const std::string& model) const;
  // The same as a machine-independent shell line, with paths as in the list.
  std::string Command() const;
};

// In execution order: by seed, data, setting, so that an interrupted study has completed whole
// seeds first. Throws Error naming field and value.
std::vector<StudyRun> ReadStudyList(const std::string& path);

// Joins the arguments to a shell line, quoted where needed.
std::string ShellLine(const std::vector<std::string>& arguments);

}  // namespace cosplat

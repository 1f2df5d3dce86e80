#include "apps/study/runs/study_list.h"

#include <algorithm>
#include <cctype>
#include <set>

#include "splat/base/error.h"
#include "splat/base/json.h"

namespace cosplat {
namespace {

using Strings = std::vector<std::string>;

constexpr const char *kCount = "{count}", *kValue = "{value}";

void Append(const Strings& more, Strings& all) { all.insert(all.end(), more.begin(), more.end()); }

// Otherwise a misspelt key would silently omit a setting.
void ExpectKeys(const JsonField& object, const std::set<std::string>& known) {
  if (!object.raw().is_object()) object.Fail("expected an object");
  for (const auto& [key, value] : object.raw().items())
    if (known.count(key) == 0)
      throw Error(object.file(), object[key].path(), "is not a field that a study knows");
}

Strings StringsOf(const JsonField& object, const std::string& key) {
  Strings texts;
  if (!object.Has(key)) return texts;
  const JsonField array = object[key];
  for (size_t i = 0; i < array.size(); ++i) texts.push_back(array[i].String());
  return texts;
}

std::vector<int> IntegersOf(const JsonField& object,
                            const std::string& key,
                            std::vector<int> fallback = {}) {
  if (!object.Has(key)) return fallback;
  const JsonField array = object[key];
  std::vector<int> numbers;
  for (size_t i = 0; i < array.size(); ++i) {
    const int number = array[i].Integer();
    const auto fail = [&](const char* problem) {
      throw Error(
          array.file(), array[i].path(), "found " + std::to_string(number) + ", " + problem);
    };
    if (number < 0) fail("expected a number >= 0");
    if (std::count(numbers.begin(), numbers.end(), number) > 0) fail("which is there already");
    numbers.push_back(number);
  }
  return numbers;
}

// Names are used as folders and are quoted in tables.
std::string CheckedName(const JsonField& field) {
  const std::string name = field.String();
  const bool ok =
      !name.empty() && name[0] != '.' && std::all_of(name.begin(), name.end(), [](char c) {
        return std::isalnum(uint8_t(c)) || c == '-' || c == '_' || c == '.';
      });
  if (!ok) field.Fail("'" + name + "' is not a name: letters, digits, '-', '_' and '.' are");
  return name;
}

struct Defaults {
  Strings arguments;
  std::vector<int> checkpoints, seeds{0};
};

Defaults DefaultsOf(const JsonField& list) {
  Defaults d;
  if (!list.Has("defaults")) return d;
  const JsonField field = list["defaults"];
  ExpectKeys(field, {"arguments", "checkpoints", "seeds"});
  d.arguments = StringsOf(field, "arguments");
  d.checkpoints = IntegersOf(field, "checkpoints");
  d.seeds = IntegersOf(field, "seeds", d.seeds);
  return d;
}

// The location of the data, or the arguments that generate its head.
void ReadSource(const JsonField& field, StudyData& data) {
  if (!field.Has("make_head")) {
    data.source = field["source"].String();
    if (data.avatar) data.flame = field["flame"].String();
    return;
  }
  const std::string path = field["make_head"].path();
  if (!data.avatar) throw Error(field.file(), path, "is for avatars; this is a scene");
  if (field.Has("source") || field.Has("flame"))
    throw Error(field.file(), path, "replaces source and flame, but one of them is also given");
  data.make_head = StringsOf(field, "make_head");
  data.source = data.name;
  data.flame = data.name + "/model.npz";
}

StudyData DataOf(const JsonField& field, const Defaults& defaults) {
  ExpectKeys(field,
             {"name",
              "kind",
              "source",
              "flame",
              "make_head",
              "arguments",
              "checkpoints",
              "counts",
              "seeds",
              "published"});
  StudyData data;
  data.name = CheckedName(field["name"]);
  const std::string kind = field["kind"].String();
  if (kind != "scene" && kind != "avatar")
    field["kind"].Fail("found '" + kind + "': scene or avatar");
  data.avatar = kind == "avatar";
  ReadSource(field, data);
  data.arguments = defaults.arguments;
  Append(StringsOf(field, "arguments"), data.arguments);
  data.checkpoints = IntegersOf(field, "checkpoints", defaults.checkpoints);
  data.counts = IntegersOf(field, "counts");
  data.seeds = IntegersOf(field, "seeds", defaults.seeds);
  if (!field.Has("published")) return data;
  for (const auto& [system, ignored] : field["published"].raw().items()) {
    const JsonField figures = field["published"][system];
    ExpectKeys(figures, {"PSNR", "SSIM", "LPIPS_vgg", "LPIPS_alex", "LPIPS_squeeze", "gaussians"});
    for (const auto& [key, value] : figures.raw().items())
      data.published[system][key] = figures[key].Number();
  }
  return data;
}

std::vector<StudyData> AllDataOf(const JsonField& list, const Defaults& defaults) {
  std::vector<StudyData> all;
  const JsonField field = list["data"];
  for (size_t i = 0; i < field.size(); ++i) all.push_back(DataOf(field[i], defaults));
  return all;
}

// One copy of the run for each value of its placeholder, or the run unchanged.
std::vector<StudyRun> Expand(const JsonField& field, const StudyRun& run) {
  const auto uses = [&](const char* what) {
    return std::find(run.arguments.begin(), run.arguments.end(), what) != run.arguments.end();
  };
  Strings values;
  const char* placeholder = uses(kCount) ? kCount : kValue;
  if (uses(kCount) && (uses(kValue) || field.Has("values")))
    field["arguments"].Fail(std::string("has ") + kCount + ", which does not go with values");
  if (uses(kCount)) {
    for (const int count : run.data.counts) values.push_back(std::to_string(count));
    if (values.empty())
      field["arguments"].Fail(std::string("has ") + kCount + ", but the data '" + run.data.name +
                              "' has no counts");
  } else if (uses(kValue) || field.Has("values")) {
    const JsonField array = field["values"];
    for (size_t i = 0; i < array.size(); ++i) {
      array[i].Number();
      values.push_back(array[i].raw().dump());
    }
    if (values.empty() || !uses(kValue))
      throw Error(field.file(), array.path(), std::string("and ") + kValue + " go together");
  } else {
    return {run};
  }
  std::vector<StudyRun> all;
  for (const std::string& value : values) {
    all.push_back(run);
    all.back().name += "-" + value;
    std::replace(
        all.back().arguments.begin(), all.back().arguments.end(), std::string(placeholder), value);
  }
  return all;
}

// On every data set that it names, or on all, with seed 0.
std::vector<StudyRun> RunsOf(const JsonField& field, const std::vector<StudyData>& all_data) {
  ExpectKeys(field, {"name", "label", "groups", "minus", "arguments", "values", "data", "seeds"});
  StudyRun run;
  run.name = CheckedName(field["name"]);
  run.label = field.Has("label") ? field["label"].String() : run.name;
  run.groups = StringsOf(field, "groups");
  if (run.groups.empty()) run.groups = {"all"};
  run.minus = StringsOf(field, "minus");
  run.arguments = StringsOf(field, "arguments");
  run.seeds = IntegersOf(field, "seeds");
  Strings wanted = StringsOf(field, "data");
  for (const std::string& name : wanted)
    if (std::none_of(
            all_data.begin(), all_data.end(), [&](const auto& d) { return d.name == name; }))
      field["data"].Fail("'" + name + "' is not among the list's data");
  std::vector<StudyRun> runs;
  std::set<int> seeds;
  for (const StudyData& data : all_data) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), data.name) == wanted.end())
      continue;
    run.data = data;
    seeds.insert(data.seeds.begin(), data.seeds.end());
    for (StudyRun& expanded : Expand(field, run)) runs.push_back(std::move(expanded));
  }
  for (const int seed : run.seeds)
    if (seeds.count(seed) == 0)
      field["seeds"].Fail("found " + std::to_string(seed) + ", which is no seed of its data");
  return runs;
}

void CheckNames(const JsonField& list, const std::vector<StudyRun>& runs) {
  std::set<std::string> ids, names;
  for (const StudyRun& run : runs) {
    names.insert(run.name);
    if (!ids.insert(run.Id()).second)
      throw Error(list.file(), "runs", "two are named '" + run.Id() + "'");
  }
  for (const StudyRun& run : runs)
    for (const std::string& other : run.minus)
      if (names.count(other) == 0)
        throw Error(list.file(), "runs", "'" + run.name + "' minus '" + other + "': there is none");
}

std::string Quoted(const std::string& argument) {
  const bool plain = !argument.empty() && std::all_of(argument.begin(), argument.end(), [](char c) {
    return std::isalnum(uint8_t(c)) || std::string("-_./=+,:").find(c) != std::string::npos;
  });
  if (plain) return argument;
  std::string out = "'";
  for (const char c : argument) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

std::string ShellLine(const Strings& arguments) {
  std::string line;
  for (const std::string& argument : arguments) {
    if (!line.empty()) line += ' ';
    line += Quoted(argument);
  }
  return line;
}

std::string StudyRun::Id() const { return data.name + "/" + name + "/" + std::to_string(seed); }

Strings StudyRun::TrainArguments(const std::string& data_folder,
                                 const std::string& out,
                                 const std::string& model) const {
  const std::string& folder = data.make_head ? out : data_folder;
  Strings all{data.avatar ? "train-avatar" : "train-scene", "-s", folder + data.source};
  if (data.avatar) Append({"--flame", folder + data.flame}, all);
  Append({"-m", model}, all);
  Append(data.arguments, all);
  Append(arguments, all);
  Append({"--seed", std::to_string(seed)}, all);
  for (const char* option : {"--test_iterations", "--save_iterations"}) {
    if (data.checkpoints.empty()) continue;
    all.push_back(option);
    for (const int step : data.checkpoints) all.push_back(std::to_string(step));
  }
  return all;
}

std::string StudyRun::Command() const {
  std::string line;
  if (data.make_head) {
    Strings film{"cosplat", "make-head", "-o", data.source};
    Append(*data.make_head, film);
    line = ShellLine(film) + " && ";
  }
  Strings train{"cosplat"};
  Append(TrainArguments("", "", "MODEL"), train);
  return line + ShellLine(train);
}

std::vector<StudyRun> ReadStudyList(const std::string& path) {
  const JsonField list(path, ReadJson(path));
  ExpectKeys(list, {"defaults", "data", "runs"});
  const std::vector<StudyData> data = AllDataOf(list, DefaultsOf(list));
  std::vector<StudyRun> once;
  const JsonField runs = list["runs"];
  for (size_t i = 0; i < runs.size(); ++i)
    for (StudyRun& run : RunsOf(runs[i], data)) once.push_back(std::move(run));
  CheckNames(list, once);
  std::vector<StudyRun> all;
  size_t rounds = 0;
  for (const StudyData& one : data) rounds = std::max(rounds, one.seeds.size());
  for (size_t round = 0; round < rounds; ++round)
    for (const StudyData& one : data)
      for (StudyRun run : once) {
        if (run.data.name != one.name || round >= one.seeds.size()) continue;
        run.seed = one.seeds[round];
        if (!run.seeds.empty() && std::count(run.seeds.begin(), run.seeds.end(), run.seed) == 0)
          continue;
        all.push_back(std::move(run));
      }
  return all;
}

}  // namespace cosplat

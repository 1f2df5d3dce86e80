// cosplat-study: measures settings, data sets and seeds side by side.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/run/progress_bar.h"
#include "apps/study/avatar_stability/cases.h"
#include "apps/study/bench/machine.h"
#include "apps/study/commands.h"
#include "apps/study/runs/study_page.h"
#include "apps/study/runs/study_runner.h"
#include "apps/study/runs/study_slurm.h"
#include "apps/study/stability/cases.h"
#include "apps/study/stability/stability_page.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/eval/lpips.h"

namespace cosplat {
namespace fs = std::filesystem;

namespace {

struct StudyCommand : StudySettings {
  std::string list, only, charts, run, sbatch;
  bool slurm = false, dry_run = false, page = false, stability = false, quiet = false;
};

// Whether the text of --only occurs in "basis/fox-8/dcsh/0", for any of the run's groups.
bool IsWanted(const StudyRun& run, const std::string& only) {
  return std::any_of(run.groups.begin(), run.groups.end(), [&](const std::string& group) {
    return (group + "/" + run.Id()).find(only) != std::string::npos;
  });
}

std::vector<StudyRun> WantedRuns(const StudyCommand& o) {
  std::vector<StudyRun> runs = ReadStudyList(o.list);
  const auto unwanted = [&](const StudyRun& run) {
    return !IsWanted(run, o.only) || (!o.run.empty() && run.Id() != o.run);
  };
  runs.erase(std::remove_if(runs.begin(), runs.end(), unwanted), runs.end());
  if (runs.empty() && !o.run.empty())
    throw Error("--run '" + o.run + "'", "is no run of " + o.list);
  if (runs.empty()) throw Error("--only '" + o.only + "'", "matches no run of " + o.list);
  return runs;
}

// Whether the run was measured before, with the same command.
bool IsFinished(const StudyRun& run, const std::vector<StudyLine>& lines) {
  return std::any_of(lines.begin(), lines.end(), [&](const StudyLine& line) {
    return line.Id() == run.Id() && line.command == run.Command();
  });
}

std::vector<StudyRun> UnfinishedOf(const std::vector<StudyRun>& runs,
                                   const std::vector<StudyLine>& lines) {
  std::vector<StudyRun> left;
  for (const StudyRun& run : runs)
    if (!IsFinished(run, lines)) left.push_back(run);
  return left;
}

// Mean time of the runs on the same data, or of all runs; there must be at least one.
double ExpectedSeconds(const StudyRun& run, const std::vector<StudyLine>& lines) {
  double same = 0, all = 0;
  size_t same_count = 0;
  for (const StudyLine& line : lines) {
    const StudyFigures& last = line.checkpoints.back();
    const double seconds = last.count("run_seconds") ? last.at("run_seconds") : 0;
    all += seconds;
    if (line.data != run.data.name) continue;
    same += seconds;
    ++same_count;
  }
  return same_count > 0 ? same / double(same_count) : all / double(lines.size());
}

// Results of the run just measured, and the expected time of those from `next` on.
std::string Progress(const std::vector<StudyLine>& lines,
                     const std::vector<StudyRun>& runs,
                     size_t next) {
  const StudyFigures& last = lines.back().checkpoints.back();
  double left = 0;
  for (size_t i = next; i < runs.size(); ++i) left += ExpectedSeconds(runs[i], lines);
  const int minutes = int(left / 60 + 0.5);
  char text[128];
  std::snprintf(text,
                sizeof text,
                "%.2f dB, %s Gaussians, %.0f s; %d:%02d h left",
                last.at("PSNR"),
                WithThousands(size_t(last.at("gaussians"))).c_str(),
                last.at("run_seconds"),
                minutes / 60,
                minutes % 60);
  return text;
}

// A run by itself has a file of its own, since others may be running elsewhere.
std::string LinesOf(const StudyCommand& o) {
  std::string name = o.run.empty() ? "runs" : "run+" + o.run;
  std::replace(name.begin(), name.end(), '/', '+');
  return name + ".jsonl";
}

// Submits what is not finished.
void Submit(const StudyCommand& o, const std::vector<StudyRun>& all) {
  const StudyChildren children;
  const std::vector<StudyRun> runs = UnfinishedOf(all, ReadStudyLines(o.out).lines);
  if (runs.empty()) {
    if (!o.quiet) std::printf("all %zu runs are done\n", all.size());
    return;
  }
  for (const StudyRun& run : runs) PrepareStudyData(run, o, children);
  const std::string job = SubmitStudy(runs, o, {o.list, o.sbatch});
  if (!o.quiet)
    std::printf(
        "%zu of %zu runs submitted as job %s; when they are done: cosplat-study --page -o %s\n",
        runs.size(),
        all.size(),
        job.c_str(),
        o.out.c_str());
}

// What the runs' data sets state as published.
std::vector<StudyLine> PublishedOf(const std::vector<StudyRun>& runs) {
  std::vector<StudyLine> lines;
  for (const StudyRun& run : runs)
    for (const auto& [system, figures] : run.data.published) {
      StudyLine line;
      line.data = run.data.name, line.name = line.label = system;
      line.checkpoints = {figures};
      line.checkpoints[0]["iterations"] = 0;  // not known
      const auto same = [&](const StudyLine& other) { return other.Id() == line.Id(); };
      if (std::none_of(lines.begin(), lines.end(), same)) lines.push_back(std::move(line));
    }
  return lines;
}

// Returns the number of failed runs.
size_t RunAll(const StudyCommand& o, const std::vector<StudyRun>& all) {
  const StudyChildren children;
  if (!o.lpips.empty()) Lpips net(o.lpips);  // a bad network fails now, not after training
  StudyLog log(o.out, LinesOf(o));
  std::vector<StudyLine> lines = ReadStudyLines(o.out).lines;
  const std::vector<StudyRun> runs = UnfinishedOf(all, lines);
  const auto say = [&](const std::string& text) {
    if (!o.quiet) std::printf("%s\n", text.c_str());
    std::fflush(stdout);
  };
  say(std::to_string(all.size() - runs.size()) + " of " + std::to_string(all.size()) +
      " runs are done");
  size_t failed = 0;
  for (size_t i = 0; i < runs.size(); ++i) {
    say(std::to_string(i + 1) + "/" + std::to_string(runs.size()) + " " + runs[i].Id());
    try {
      lines.push_back(MeasureStudyRun(runs[i], o, children));
      log.Append(lines.back());
      say("  " + Progress(lines, runs, i + 1));
      if (!o.keep) fs::remove_all(StudyModelFolder(runs[i], o));
    } catch (const StudyStopped&) {
      throw;
    } catch (const std::exception& e) {  // includes file system errors
      std::fprintf(stderr, "cosplat-study: %s: %s\n", runs[i].Id().c_str(), e.what());
      ++failed;
    }
  }
  return failed;
}

void PrintRuns(const std::vector<StudyRun>& runs, const std::vector<StudyLine>& lines) {
  for (const StudyRun& run : runs)
    std::printf("%s %s: %s\n",
                IsFinished(run, lines) ? "done" : "todo",
                run.Id().c_str(),
                run.Command().c_str());
}

void WritePage(const StudyCommand& o) {
  WriteStudyPage(o.out, o.charts);
  if (!o.quiet) std::printf("page: %s/index.html\n", o.out.c_str());
}

void AppendCases(std::vector<StabilityCase> more, std::vector<StabilityCase>& all) {
  for (StabilityCase& s : more) all.push_back(std::move(s));
}

// Runs all cases of the stability suite, times the implementations of colour evaluation, and writes
// <folder>/basis_forms.svg, the self-contained page <folder>/stability.html and, last,
// <folder>/stability.json. Throws Error if the folder cannot be written to.
void WriteStabilityPage(const std::string& folder, bool quiet) {
  constexpr int kTimedBatches = 200;
  constexpr int kParts = 3;
  MakeDirectories(folder);
  StabilityResults results;
  results.machine = CpuName() + ", " + SimdTargets().at(0).name;
  {
    ProgressBar bar("stability", kParts, quiet);
    bar.Update(0, "forms of the basis");
    results.forms = MeasureBasisForms(kTimedBatches);
    bar.Update(1, "splats");
    AppendCases(SplatStability(), results.cases);
    bar.Update(2, "avatars");
    AppendCases(AvatarStability(), results.cases);
  }
  WriteFileAtomically(folder + "/basis_forms.svg", ToSvg(FormsChart(results.forms)));
  WriteFileAtomically(folder + "/stability.html", StabilityHtml(results));
  WriteFileAtomically(folder + "/stability.json", StabilityJson(results).dump(2) + "\n");
  if (!quiet) std::printf("%zu cases: %s/stability.html\n", results.cases.size(), folder.c_str());
}

void Study(const StudyCommand& o) {
  if (o.out.empty()) throw Error("--out", "is required");
  if (o.stability) return WriteStabilityPage(o.out, o.quiet);
  if (o.page) return WritePage(o);
  if (o.list.empty() || o.data.empty())
    throw Error("--list, --data", "are required unless --page or --stability is given");
  const std::vector<StudyRun> runs = WantedRuns(o);
  if (o.dry_run) return PrintRuns(runs, ReadStudyLines(o.out).lines);
  if (o.slurm) return Submit(o, runs);
  if (const auto published = PublishedOf(runs); !published.empty())
    WritePublished(o.out, published);
  const size_t failed = RunAll(o, runs);
  if (failed < runs.size() && o.run.empty()) WritePage(o);
  if (failed > 0)
    throw Error("study",
                "",
                std::to_string(failed) + " of " + std::to_string(runs.size()) + " runs failed");
}

}  // namespace

void DeclareStudy(CLI::App& app) {
  const auto o = std::make_shared<StudyCommand>();
  app.add_option("--list", o->list, "what to run (.json)")->default_str("");
  app.add_option("--data", o->data, "folder of the list's data sets")->default_str("");
  app.add_option("-o,--out", o->out, "folder of runs.jsonl and the page, index.html")
      ->default_str("");
  app.add_option("--only", o->only, "only runs of which group/data/name/seed has this text")
      ->default_str("");
  app.add_option("--run",
                 o->run,
                 "only this data/name/seed, with a file of lines of its own: others may run "
                 "elsewhere at the same time")
      ->default_str("");
  app.add_flag("--slurm", o->slurm, "submit the runs as an array job of Slurm, by sbatch");
  app.add_option("--sbatch", o->sbatch, "with --slurm: sbatch's options, separated by spaces")
      ->default_str("");
  app.add_option("--lpips", o->lpips, "measure LPIPS too, with the net of this folder")
      ->default_str("");
  app.add_flag("--page", o->page, "run nothing, write the page of the runs that are done");
  app.add_flag("--stability",
               o->stability,
               "run the stability suite instead of a list: known failure cases, naive form against "
               "ours");
  app.add_option("--charts", o->charts, "write the page's charts into this folder, too")
      ->default_str("");
  app.add_flag("--dry-run", o->dry_run, "print the commands, those that are done included");
  app.add_flag("--keep", o->keep, "keep the models");
  app.add_flag("--quiet", o->quiet, "print nothing but errors");
  app.callback([&app, o] {
    if (app.get_subcommands().empty()) Study(*o);
  });
}

}  // namespace cosplat

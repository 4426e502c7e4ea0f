#include <filesystem>
#include <map>
#include <optional>

#include "geometry/json_file.hpp"
#include "report/experiment_folder.hpp"
#include "report/record_folder.hpp"
#include "report/run_folder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kOneExperiment = "merge shards of one experiment, made by the same program";

/// Record of a shard.
struct ShardRecord {
  std::string folder;
  Experiment experiment;
  RunTexts runs;
  std::string options;  ///< of all runs, YAML
};

/// One run in the record of its shard.
struct ShardRun {
  const ShardRecord* shard = nullptr;
  std::size_t place = 0;  ///< in its list of runs
  [[nodiscard]] const ExperimentRun& run() const { return shard->experiment.runs[place]; }
  [[nodiscard]] std::string folder() const { return folder_of_run(shard->folder, run().number); }
};
/// All runs, by number.
using ShardRuns = std::map<int, ShardRun>;

ShardRecord read_shard(const std::string& folder) {
  const std::string file = experiment_file(folder);
  ShardRecord shard{folder, read_experiment(file), {}, {}};
  if (shard.experiment.total == 0)
    throw FileError(file, "an older version made it, which did not record seed and number of runs",
                    kOneExperiment);
  shard.runs = run_texts(read_json(file));  // more than a moment ago, if the shard still goes on
  shard.options = read_file(options_file(folder), 1U << 20U);
  return shard;
}

/// Refuses a shard in which `what` is another value than in the first.
template <class Value>
void check_same(const ShardRecord& first, const ShardRecord& shard, const std::string& what,
                const Value& of_first, const Value& of_shard) {
  if (of_first == of_shard) return;
  throw FileError(shard.folder,
                  concat("has ", what, " ", of_shard, ", but ", first.folder, " has ", of_first),
                  kOneExperiment);
}

std::string joined_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

void check_same_experiment(const ShardRecord& first, const ShardRecord& shard) {
  const Experiment &a = first.experiment, &b = shard.experiment;
  check_same(first, shard, "--seed", a.seed, b.seed);
  check_same(first, shard, "--runs", a.total, b.total);
  check_same(first, shard, "--per-run", a.per_run, b.per_run);
  check_same(first, shard, "--protocol", a.protocol, b.protocol);
  check_same(first, shard, "--new-stones", a.new_stones, b.new_stones);
  check_same(first, shard, "--new-stones-from", a.new_stones_from, b.new_stones_from);
  check_same(first, shard, "the stones", joined_names(a.stones), joined_names(b.stones));
  const auto [option, other] = first_difference(first.options, shard.options);
  check_same(first, shard, "the option", option, other);
  check_same(first, shard, "the title", a.title, b.title);  // what is in none of these: robot
}

/// Refuses a run that is not of the experiment, or whose record is not whole.
void check_run(const ShardRun& first, const ShardRun& one) {
  const ExperimentRun &a = first.run(), &b = one.run();
  const Experiment& experiment = one.shard->experiment;
  const std::string run = concat("run ", b.number);
  const auto refuse = [&](const std::string& problem) {
    throw FileError(one.shard->folder, concat(run, " ", problem), kOneExperiment);
  };
  if (b.number > experiment.total) refuse(concat("is not one of ", experiment.total, " runs"));
  if (const long long seed = 1000LL * experiment.seed + b.number; b.report.seed != seed)
    refuse(concat("has the seed ", b.report.seed, ", not ", seed));
  check_same(*first.shard, *one.shard, run + " of the version", a.report.version, b.report.version);
  const auto survival = [](const ExperimentRun& of) {
    return of.survival.standing.empty() ? "false" : "true";
  };
  check_same(*first.shard, *one.shard, run + " with --survival", std::string(survival(a)),
             std::string(survival(b)));
  if (!fs::is_directory(one.folder())) refuse("has no folder run-N beside experiment.json");
}

ShardRuns collect_runs(const std::vector<ShardRecord>& shards) {
  ShardRuns runs;
  std::optional<ShardRun> first;
  for (const ShardRecord& shard : shards)
    for (std::size_t place = 0; place < shard.experiment.runs.size(); ++place) {
      const ShardRun one{&shard, place};
      if (!first) first = one;
      check_run(*first, one);
      const auto [there, is_new] = runs.insert({one.run().number, one});
      if (!is_new)
        throw FileError(shard.folder,
                        concat("run ", one.run().number, " is in ", there->second.shard->folder, ", too"),
                        "name each shard once");
    }
  return runs;
}

/// Runs from 1 to `total` that are not among `runs`.
std::string missing_runs(const ShardRuns& runs, int total) {
  std::vector<int> missing;
  for (int k = 1; k <= total; ++k)
    if (runs.count(k) == 0) missing.push_back(k);
  return listed_runs(missing);
}

/// Makes the folder, which must not be in a shard.
RecordFolder make_folder(const std::string& out, const std::vector<ShardRecord>& shards) {
  const fs::path path = fs::weakly_canonical(out.empty() ? "experiments" : out);
  for (const ShardRecord& shard : shards) {
    const fs::path below = path.lexically_relative(fs::canonical(shard.folder));
    require(below.empty() || *below.begin() == "..", path.string(), " is in the shard ", shard.folder,
            ", into which nothing is written; name another folder with --out");
  }
  if (out.empty()) return RecordFolder::make_new(stamped_name("experiments", shards.front().experiment.seed));
  RecordFolder folder(out);
  require(folder.made(), out, " is there already; name another folder with --out");
  return folder;
}

void copy_folder(const std::string& from, const std::string& to) {
  std::error_code problem;
  fs::copy(from, to, fs::copy_options::recursive | fs::copy_options::copy_symlinks, problem);
  if (problem)
    throw FileError(from, concat("cannot be copied to ", to, ": ", problem.message()),
                    "merge again where there is room");
}

void fill(const std::string& folder, const Experiment& experiment, const ShardRuns& runs,
          const std::string& options) {
  for (const auto& [number, one] : runs) {
    throw_if_interrupted();
    copy_folder(one.folder(), folder_of_run(folder, number));
  }
  write_file(options_file(folder), options);
  RunTexts texts;
  for (const auto& [number, one] : runs) {
    json& run = texts[number] = one.shard->runs.at(number);
    if (run.contains("modelling")) run["modelling"]["catalogue"] = folder_of_run(folder, number) + "/stones";
  }
  write_record(experiment, texts, folder);
}

}  // namespace

RecordedExperiment merge_experiments(const std::vector<std::string>& shards, const std::string& out) {
  require(!shards.empty(), "a merge needs the folder of at least one shard");
  std::vector<ShardRecord> records;
  for (const std::string& folder : shards) {
    records.push_back(read_shard(folder));
    check_same_experiment(records.front(), records.back());
  }
  const ShardRuns runs = collect_runs(records);
  RecordedExperiment done;
  done.experiment = records.front().experiment;
  done.experiment.shard = {};
  done.experiment.runs.clear();
  for (const auto& [number, one] : runs) done.experiment.runs.push_back(one.run());
  done.missing = missing_runs(runs, done.experiment.total);
  const RecordFolder folder = make_folder(out, records);
  done.folder = folder.path();
  try {
    fill(done.folder, done.experiment, runs, records.front().options);
  } catch (...) {  // a part of a record is none
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(done.folder)) fs::remove_all(entry.path(), ignored);
    throw;
  }
  log_info(concat(runs.size(), " runs of ", records.size(), " folders merged"));
  return done;
}

}  // namespace stonestack::report

#include "bench.hpp"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <set>

#include "version.hpp"

#include "geometry/json_file.hpp"
#include "report/experiment_folder.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::bench {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

constexpr const char* kShardSchema = "stonestack.bench_shard/1";
constexpr const char* kWhatShardWrote = "name what --shard wrote with --record";
constexpr const char* kOneBenchmark = "merge shards of one benchmark, made by the same program";

/// The command line of this process, as one would type it.
std::string own_command() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string words((std::istreambuf_iterator<char>(file)), {});
  if (!words.empty() && words.back() == '\0') words.pop_back();
  std::replace(words.begin(), words.end(), '\0', ' ');
  const std::size_t end = words.find(' ');
  return "bench" + (end == std::string::npos ? "" : words.substr(end));
}

/// Where results go, and which draws are performed.
struct HowToMeasure {
  bool json = false;
  std::string record;
  std::string shard = "1/1";
  bool continues = false;
  Words merge;
  bool has_recorded_arguments = false;  ///< the options have the values of the shards that are merged
};

void register_output(CLI::App& sub, HowToMeasure& how) {
  sub.add_flag("--json", how.json, "Result as JSON on stdout (schema stonestack.bench/1)");
  sub.add_option("--record", how.record,
                 "Write the result and the command to this JSON file, for docs/results");
}

/// Options that were given, "--name=value", but those about how it is measured.
Words arguments_of(const CLI::App& sub) {
  const std::set<std::string> how{"--json", "--record", "--shard", "--continue", "--merge"};
  Words words;
  for (const CLI::Option* option : sub.get_options([](const auto* o) { return o->count() > 0; }))
    if (how.count(option->get_name()) == 0)
      for (const std::string& value : option->results())
        words.push_back(concat(option->get_name(), '=', value));
  return words;
}

/// The command line of a benchmark with these arguments.
std::string command_of(const std::string& benchmark, const Words& arguments) {
  std::string text = "bench " + benchmark;
  for (const std::string& word : arguments) text += ' ' + word;
  return text;
}

/// `measure` with results of its own, which are printed whether it ends, fails or is interrupted.
void print_results(Results& results, const std::function<void()>& measure) {
  try {
    measure();
  } catch (...) {
    results.finish(false);
    throw;
  }
  results.finish(true);
}

/// Content of the file of a shard.
std::string shard_text(const Results& results, const Draws& draws, const Words& arguments,
                       const std::string& shard, bool complete) {
  json text = json::parse(results.record({}));
  text.erase("command");
  text["schema"] = kShardSchema;
  text["complete"] = complete;
  text["arguments"] = arguments;
  text["shard"] = shard;
  text["draws"] = draws.records();
  return text.dump(1) + '\n';
}

json read_shard_file(const std::string& path, const std::string& benchmark) {
  json file = read_json(path);
  const auto is_text = [&](const char* key, const std::string& text) {
    return file.contains(key) && file[key] == text;
  };
  if (!file.is_object() || !is_text("schema", kShardSchema) || !is_text("benchmark", benchmark))
    throw FileError(path, "is no shard of `" + benchmark + '`', kWhatShardWrote);
  for (const char* key : {"version", "settings", "arguments", "shard", "draws"})
    if (!file.contains(key)) throw FileError(path, concat("has no `", key, '`'), kWhatShardWrote);
  const json& arguments = file["arguments"];
  if (!arguments.is_array() ||
      !std::all_of(arguments.begin(), arguments.end(), [](const json& word) { return word.is_string(); }))
    throw FileError(path, "has `arguments` that are no list of texts", kWhatShardWrote);
  return file;
}

/// Refuses a shard in which `what` is another value than expected.
void check_shard(const std::string& path, const std::string& what, const json& expected, const json& found) {
  if (expected == found) return;
  throw FileError(path, concat("was made with the ", what, ' ', found.dump(), ", not ", expected.dump()),
                  kOneBenchmark);
}

void add_draws(Draws& draws, const std::string& path, const json& file) {
  try {
    draws.add(file.at("draws"));
  } catch (const std::exception& fault) {
    throw FileError(path, fault.what(), "name each shard once, as it was written");
  }
}

void throw_if_missing(const Draws& draws, const std::string& remedy) {
  if (!draws.missing().empty())
    throw FileError("the record", "lacks the draws " + report::listed_runs(draws.missing()), remedy);
}

using MeasureDraws = std::function<void(Results&, Draws&)>;

void measure_shard(const CLI::App& sub, const HowToMeasure& how, const MeasureDraws& measure) {
  require(!how.record.empty(), "--shard needs --record FILE, which --merge reads");
  const Words arguments = arguments_of(sub);
  Results results(sub.get_name(), {how.json, program_version()}, std::cout, std::cerr);
  Draws* all = nullptr;
  const auto keep = [&](bool complete) {
    write_file(how.record, shard_text(results, *all, arguments, how.shard, complete));
  };
  Draws draws(parse_shard(how.shard), [&] { keep(false); });
  all = &draws;
  json before;
  if (how.continues) {
    before = read_shard_file(how.record, sub.get_name());
    check_shard(how.record, "version", program_version(), before["version"]);
    check_shard(how.record, "arguments", arguments, before["arguments"]);
    check_shard(how.record, "shard", how.shard, before["shard"]);
    add_draws(draws, how.record, before);
  } else {
    require_writable(how.record);
  }
  print_results(results, [&] { measure(results, draws); });
  throw_if_interrupted();
  keep(true);
}

/// The tables of the draws that shards have performed.
void merge_shards(CLI::App& sub, const HowToMeasure& how, const MeasureDraws& measure) {
  Results results(sub.get_name(), {how.json, program_version()}, std::cout, std::cerr);
  Draws draws = Draws::of_shards();
  json first;
  for (const std::string& path : how.merge) {
    const json file = read_shard_file(path, sub.get_name());
    if (first.is_null()) first = file;
    check_shard(path, "version", program_version(), file["version"]);
    for (const char* what : {"arguments", "settings"}) check_shard(path, what, first[what], file[what]);
    add_draws(draws, path, file);
  }
  const Words arguments = first["arguments"];
  print_results(results, [&] {
    measure(results, draws);
    check_shard(how.merge.front(), "settings", json::parse(results.record({}))["settings"],
                first["settings"]);
    throw_if_missing(draws, concat("perform them with --continue: `", command_of(sub.get_name(), arguments),
                                   " --shard I/N --record FILE --continue`"));
  });
  if (!how.record.empty()) write_file(how.record, results.record(command_of(sub.get_name(), arguments)));
}

/// Parses the arguments that the shards have recorded, which calls the benchmark again.
void parse_recorded_arguments(CLI::App& sub, HowToMeasure& how) {
  const Words given = arguments_of(sub);
  require(given.empty(), "--merge takes all options from the records: leave out ",
          given.empty() ? "" : given.front());
  const json file = read_shard_file(how.merge.front(), sub.get_name());
  Words words = file["arguments"];
  std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
  how.has_recorded_arguments = true;
  sub.parse(words);
}

void measure_whole(const CLI::App& sub, const HowToMeasure& how,
                   const std::function<void(Results&)>& measure) {
  if (!how.record.empty()) require_writable(how.record);
  Results results(sub.get_name(), {how.json, program_version()}, std::cout, std::cerr);
  print_results(results, [&] { measure(results); });
  if (!how.record.empty()) write_file(how.record, results.record(own_command()));
}

}  // namespace

void measure_by(CLI::App& sub, std::function<void(Results&)> measure) {
  auto how = std::make_shared<HowToMeasure>();
  register_output(sub, *how);
  sub.callback([&sub, how, measure = std::move(measure)] { measure_whole(sub, *how, measure); });
}

void measure_draws_by(CLI::App& sub, MeasureDraws measure) {
  auto how = std::make_shared<HowToMeasure>();
  register_output(sub, *how);
  CLI::Option* const shard = sub.add_option(
      "--shard", how->shard, "I/N: performs one of N parts of the draws and records it in the file --record");
  sub.add_flag("--continue", how->continues, "Go on with the shard that --record holds")->needs(shard);
  sub.add_option("--merge", how->merge, "Performs nothing: the tables of these records of all shards")
      ->type_name("FILE")
      ->excludes(shard);
  sub.callback([&sub, shard, how, measure = std::move(measure)] {
    if (how->has_recorded_arguments) return merge_shards(sub, *how, measure);
    if (!how->merge.empty()) return parse_recorded_arguments(sub, *how);
    if (shard->count() > 0) return measure_shard(sub, *how, measure);
    measure_whole(sub, *how, [&](Results& results) {
      Draws all;
      measure(results, all);
    });
  });
}

}  // namespace stonestack::bench

// Does a run survive its program? Runs of the command are killed (SIGKILL) at random times and go on with
// --resume. The tower is judged in the simulation's true world, and the record has to be whole: every line of
// the journal once, every placement once, no stone lost.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <thread>

#include "bench.hpp"
#include "stacking/journal.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Steady = std::chrono::steady_clock;

constexpr std::size_t kMaxRecord = std::size_t{1} << 28;
constexpr auto kPoll = std::chrono::milliseconds(10);

struct ResumeBench {
  int kills = 200, per_run = 4, kills_per_run = 4, seed = 1;
  int max_lines = 40;      ///< of the journal, from a start to a kill
  double max_delay = 1.5;  ///< from the last of them to the kill [s]
  std::vector<std::string> options;
  std::string out;
};

/// The command beside this program.
std::string command_path() {
  return (fs::read_symlink("/proc/self/exe").parent_path() / "stonestack").string();
}

/// Starts the command; its messages go into `log`.
pid_t start(const std::vector<std::string>& arguments, const std::string& log) {
  const std::string program = command_path();
  std::vector<const char*> argv{program.c_str()};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  require(child >= 0, "no process can be started");
  if (child > 0) return child;
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  ::dup2(file, STDOUT_FILENO);
  ::dup2(file, STDERR_FILENO);
  ::execv(program.c_str(), const_cast<char* const*>(argv.data()));
  ::_exit(127);
}

long lines_of_journal(const std::string& folder) {
  const std::string path = folder + "/journal.jsonl";
  if (!fs::exists(path)) return 0;
  const std::string content = read_file(path, kMaxRecord);
  return std::count(content.begin(), content.end(), '\n');
}

/// When a process is killed: some time after the journal has so many lines.
struct Death {
  long lines = std::numeric_limits<long>::max();
  double delay = 0.0;  ///< [s]
};

/// Waits until the process ends; its exit code, or empty when it was killed.
std::optional<int> wait_or_kill(pid_t child, const std::string& folder, const Death& death) {
  const auto delay = std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(death.delay));
  std::optional<Steady::time_point> end;
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    const bool broken_off = interrupt_noted();
    if (!end && lines_of_journal(folder) >= death.lines) end = Steady::now() + delay;
    if ((end && Steady::now() >= *end) || broken_off) {
      ::kill(child, SIGKILL);
      ::waitpid(child, &status, 0);
      if (broken_off) throw Interrupted();
      return std::nullopt;
    }
    std::this_thread::sleep_for(kPoll);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// The journal of a run.
struct JournalLines {
  std::vector<json> lines;
  int wrong = 0;  ///< lines that are damaged or out of order

  explicit JournalLines(const std::string& folder) {
    const std::string path = folder + "/journal.jsonl";
    if (!fs::exists(path)) return;
    std::istringstream in(read_file(path, kMaxRecord));
    for (std::string line; std::getline(in, line) && !in.eof();) {
      json j = json::parse(line, nullptr, false);
      const bool good =
          j.is_object() && !stacking::is_damaged(line) && j.value("seq", std::size_t{0}) == lines.size();
      wrong += good ? 0 : 1;
      lines.push_back(std::move(j));
    }
  }
  /// Name of the step that began last.
  [[nodiscard]] std::string step() const {
    for (auto line = lines.rbegin(); line != lines.rend(); ++line)
      if (line->value("kind", "") == "step") return line->at("data").at("name").get<std::string>();
    return "before the first step";
  }
  /// Stones by the outcomes that count: a resumed run judges again what was in the midst of being done.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> outcomes() const {
    std::vector<std::pair<std::string, std::string>> list;
    for (const json& line : lines) {
      const json& data = line.at("data");
      if (line.at("kind") == "resumed")
        list.resize(std::min(list.size(), data.at("placements").get<std::size_t>()));
      if (line.at("kind") == "outcome")
        list.emplace_back(data.at("stone").get<std::string>(), data.at("outcome").get<std::string>());
    }
    return list;
  }
  /// Stones that the last observation shows.
  [[nodiscard]] std::size_t stones_seen() const {
    for (auto line = lines.rbegin(); line != lines.rend(); ++line)
      if (line->value("kind", "") == "observed")
        return line->at("data").at("stack").size() + line->at("data").at("loose").size();
    return 0;
  }
};

/// The record of a run that has ended.
struct RunVerdict {
  std::string ended;
  int height = 0, true_height = 0, journal_wrong = 0;
  bool stands = false, same_records = false, doubled = false, all_seen = false;
  [[nodiscard]] bool tower_right() const { return stands && true_height == height && height > 0; }
  [[nodiscard]] bool record_right() const {
    return journal_wrong == 0 && same_records && !doubled && all_seen;
  }
};

RunVerdict judge_record(const std::string& folder, int stones) {
  RunVerdict verdict;
  const JournalLines journal(folder);
  verdict.journal_wrong = journal.wrong;
  verdict.all_seen = journal.stones_seen() == static_cast<std::size_t>(stones);
  const std::string path = folder + "/result.json";
  if (!fs::exists(path)) return verdict;
  const json result = json::parse(read_file(path, kMaxRecord));
  verdict.ended = result.at("ended").get<std::string>();
  verdict.height = result.at("height").get<int>();
  if (result.contains("truth")) {
    verdict.true_height = result.at("truth").at("height").get<int>();
    verdict.stands = result.at("truth").at("stands").get<bool>();
  }
  std::vector<std::pair<std::string, std::string>> recorded;
  for (const json& placement : result.at("placements"))
    recorded.emplace_back(placement.at("stone").get<std::string>(),
                          placement.at("outcome").get<std::string>());
  verdict.same_records = recorded == journal.outcomes();
  std::set<std::string> standing;
  for (const auto& [stone, outcome] : recorded) {
    if (outcome == "placed" && !standing.insert(stone).second) verdict.doubled = true;
    if (outcome == "unstacked" || outcome == "fallen") standing.clear();  // what stands may be another tower
  }
  return verdict;
}

/// Arguments of the command that begins the run, or goes on with it.
std::vector<std::string> arguments_of(const ResumeBench& bench, int seed, const std::string& folder,
                                      bool begun) {
  if (begun) return {"run", "--resume", folder};
  std::vector<std::string> arguments{"run", "--robot", "ur10", "--out", folder};
  for (const auto& [name, value] : {std::pair("--per-run", bench.per_run), {"--seed", seed}})
    arguments.insert(arguments.end(), {name, std::to_string(value)});
  for (const std::string& option : bench.options) arguments.insert(arguments.end(), {"--set", option});
  return arguments;
}

void measure_resume(const ResumeBench& bench, Results& results) {
  results.settings({{"kills", bench.kills},
                    {"kills_per_run", bench.kills_per_run},
                    {"stones_per_run", bench.per_run},
                    {"max_lines_to_kill", bench.max_lines},
                    {"max_delay_s", bench.max_delay, 1},
                    {"seed", bench.seed}});
  results.table("runs", {{"run"},
                         {"seed"},
                         {"kills"},
                         {"refused"},
                         {"ended"},
                         {"height"},
                         {"true_height"},
                         {"stands"},
                         {"journal_wrong"},
                         {"records_as_journal"},
                         {"doubled"},
                         {"all_stones_seen"}});
  const std::string base =
      bench.out.empty() ? (fs::temp_directory_path() / concat("resume-", ::getpid())).string() : bench.out;
  int kills = 0, runs = 0, towers = 0, records = 0, early = 0, refused = 0;
  std::map<std::string, int> where;
  while (kills < bench.kills) {
    const int seed = 1000 * bench.seed + ++runs;
    Random random = Random::stream(static_cast<std::uint64_t>(seed), "kills");
    const std::string folder = concat(base, "/run-", runs), log = folder + ".log";
    fs::remove_all(folder);
    fs::create_directories(base);
    bool begun = false;
    int killed = 0, refusals = 0;
    for (;;) {
      const pid_t child = start(arguments_of(bench, seed, folder, begun), log);
      Death death;
      if (killed < bench.kills_per_run && kills < bench.kills) {
        death.lines = lines_of_journal(folder) +
                      static_cast<long>(random.index(static_cast<std::size_t>(bench.max_lines) + 1));
        death.delay = random.uniform(0.0, bench.max_delay);
      }
      if (const auto code = wait_or_kill(child, folder, death)) {
        if (!begun && !fs::exists(folder + "/result.json"))
          throw FileError(log, concat("the run ended with code ", *code, " before anything was built"),
                          "read why; check --set");
        if (begun && (*code == 2 || *code == 3)) ++refusals;
        break;
      }
      if (fs::exists(folder + "/report.html")) break;  // the run had ended
      ++killed;
      ++kills;
      if (!fs::exists(folder + "/resume.json")) {
        ++early;
        continue;
      }
      begun = true;
      ++where[JournalLines(folder).step().substr(0, 5)];
    }
    const RunVerdict verdict = judge_record(folder, bench.per_run);
    towers += verdict.tower_right() ? 1 : 0;
    records += verdict.record_right() ? 1 : 0;
    refused += refusals;
    results.row({runs, seed, killed, refusals, verdict.ended, verdict.height, verdict.true_height,
                 verdict.stands, verdict.journal_wrong, verdict.same_records, verdict.doubled,
                 verdict.all_seen});
  }
  for (const auto& [step, count] : where) results.note("killed in a step \"%s...\": %d", step.c_str(), count);
  results.figures("kills", {{"kills", kills},
                            {"before_anything_was_kept", early},
                            {"resumes_refused", refused},
                            {"runs", runs},
                            {"towers_right_by_the_true_world", towers},
                            {"records_whole", records}});
  if (bench.out.empty()) fs::remove_all(base);
}

}  // namespace

void add_resume(CLI::App& app) {
  const auto command = std::make_shared<ResumeBench>();
  CLI::App* sub = app.add_subcommand("resume", "Runs that are killed at random times, and go on");
  sub->add_option("--kills", command->kills, "Kills")->check(CLI::Range(1, 100000))->capture_default_str();
  sub->add_option("--kills-per-run", command->kills_per_run, "Kills of one run, at most")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--per-run", command->per_run, "Stones of a run")
      ->check(CLI::Range(1, 6))
      ->capture_default_str();
  sub->add_option("--max-lines", command->max_lines, "Most lines of the journal from a start to a kill")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  sub->add_option("--max-delay", command->max_delay, "Longest time from the last of them to the kill [s]")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  sub->add_option("--set", command->options, "Set an option of the runs")->type_name("NAME=VALUE");
  sub->add_option("--seed", command->seed, "Seed; run k has 1000 SEED + k")->capture_default_str();
  sub->add_option("--out", command->out, "Keep the records of the runs here")->type_name("DIR");
  sub->footer("Example:\n  stonestack-bench resume --kills 20 --seed 1");
  measure_by(*sub, [command](Results& results) { measure_resume(*command, results); });
}

}  // namespace stonestack::bench

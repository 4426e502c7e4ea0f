#include <signal.h>

#include <fstream>
#include <thread>

#include "mpi/mpi_command.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack {
namespace {

/// Runs of one stone in a cell without errors, each with stones of its own.
const char* const kShortRuns =
    "experiment --per-run 1 --new-stones 2 --seed 4 --survival false --set simulation.cell=ideal "
    "--set search.perturbations=0 --set run.measure_friction=false ";

/// A run as the file has it, without what the host's clock measured.
json without_host_times(json run) {
  for (const char* stage : {"detection", "search", "planning", "beside_motion"}) run["seconds"].erase(stage);
  return run;
}

class MpiExperiment : public MpiCommand {
 protected:
  /// The records are the same but for what the host's clock measured, to the last digit.
  void expect_same_record(const std::string& record, const std::string& whole) const {
    json a = json::parse(file(record + "/experiment.json")),
         b = json::parse(file(whole + "/experiment.json"));
    ASSERT_EQ(a["runs"].size(), b["runs"].size());
    for (std::size_t k = 0; k < a["runs"].size(); ++k)
      EXPECT_EQ(without_host_times(a["runs"][k]).dump(), without_host_times(b["runs"][k]).dump()) << record;
    a.erase("runs"), b.erase("runs");
    EXPECT_EQ(without_host_times(a).dump(), without_host_times(b).dump()) << record;
    std::vector<std::string> files{"options.yaml", "figure5.csv", "figure5.svg"};
    for (int k = 1; k <= static_cast<int>(b["runs"].size()); ++k)
      for (const char* name : {"options.yaml", "tower.png"}) files.push_back(concat("run-", k, '/', name));
    for (const std::string& name : files)
      EXPECT_EQ(file(record + "/" + name), file(whole + "/" + name)) << name;
    for (const char* name : {"runs.csv", "summary.txt", "report.html"})
      EXPECT_TRUE(fs::exists(folder_ + "/" + record + "/" + name)) << name;
  }
};

TEST_F(MpiExperiment, AnyNumberOfRanksMakesTheRecordOfOneProcess) {
  const std::string arguments = concat(kShortRuns, "--runs 3 --out ");
  const Outcome whole = run(arguments + "whole");
  ASSERT_EQ(whole.code, 0) << whole.err;
  for (const int ranks : {1, 2, 3}) {
    const std::string record = concat("on-", ranks);
    const Outcome done = run_on(ranks, arguments + record);
    ASSERT_EQ(done.code, 0) << done.err;
    expect_same_record(record, "whole");
    for (const char* line : {"run 1: height", "run 2: height", "run 3: height", "experiment: 3 of 3 runs"})
      EXPECT_THAT(done.err, HasSubstr(line));
    EXPECT_THAT(done.err, testing::Not(HasSubstr("info:"))) << "another rank, or a run of rank 0, prints";
    EXPECT_EQ(done.out.find("record: " + record), done.out.rfind("record: "))
        << "printed by more ranks than one";
  }
}

/// The process of that rank among those that `parent` has started; 0 if there is none.
pid_t find_rank(int rank, const std::string& folder) {
  const std::string mark = concat("OMPI_COMM_WORLD_RANK=", rank, '\0');
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::error_code gone;
    if (fs::read_symlink(entry.path() / "cwd", gone) != fs::path(folder) || gone) continue;
    std::ifstream environ(entry.path() / "environ", std::ios::binary);
    const std::string variables((std::istreambuf_iterator<char>(environ)), {});
    if (variables.find(mark) != std::string::npos) return std::stoi(entry.path().filename());
  }
  return 0;
}

TEST_F(MpiExperiment, AnExperimentGoesOnAfterARankWasKilled) {
  const std::string arguments = concat(kShortRuns, "--runs 4 --out ");
  std::thread killer([&] {  // as soon as one run has ended
    for (int i = 0; i < 6000; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      std::ifstream err(folder_ + "/err");
      const std::string text((std::istreambuf_iterator<char>(err)), {});
      if (text.find(": height") == std::string::npos) continue;
      if (const pid_t victim = find_rank(1, folder_); victim > 0) ::kill(victim, SIGKILL);
      return;
    }
  });
  const Outcome killed = run_on(2, arguments + "record");
  killer.join();
  EXPECT_NE(killed.code, 0) << killed.err;
  const json before = json::parse(file("record/experiment.json"));
  ASSERT_GE(before["runs"].size(), 1U);
  ASSERT_LT(before["runs"].size(), 4U) << "nothing was lost";

  const Outcome rest = run_on(2, arguments + "record --continue");
  ASSERT_EQ(rest.code, 0) << rest.err;
  const json after = json::parse(file("record/experiment.json"));
  ASSERT_EQ(after["runs"].size(), 4U);
  for (const json& done : before["runs"]) {
    const int number = done["run"];
    EXPECT_EQ(after["runs"][static_cast<std::size_t>(number - 1)].dump(), done.dump()) << "performed again";
    EXPECT_THAT(rest.err, testing::Not(HasSubstr(concat("run ", number, ": height"))));
  }
  const Outcome whole = run(arguments + "whole");
  ASSERT_EQ(whole.code, 0) << whole.err;
  expect_same_record("record", "whole");
}

TEST_F(MpiExperiment, AWrongCommandEndsAllRanks) {
  fs::create_directories(folder_ + "/there");
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"experiment --no-such-option", "no option '--no-such-option'"},
      {"experiment --merge a b", "no option '--merge'"},
      {"experiment --runs 1 --per-run 7 --out record", "--per-run 7 of 6 stones"},
      {"experiment --runs 1 --compare cell --out record", "a comparison is performed by one process"},
      {"experiment --runs 1 --out there", "is there already"}};
  for (const auto& [arguments, message] : wrong) {
    SCOPED_TRACE(arguments);
    expect_refused(run_on(3, arguments), message);
  }
  const Outcome help = run_on(3, "experiment --help");
  EXPECT_EQ(help.code, 0) << help.err;
  EXPECT_EQ(help.out.find("--threads"), help.out.rfind("--threads")) << "more ranks than one print";
}

}  // namespace
}  // namespace stonestack

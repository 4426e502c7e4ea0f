#include <signal.h>

#include <fstream>
#include <set>
#include <thread>

#include "mpi/mpi_command.hpp"

namespace stonestack {
namespace {

const std::string kSearch = "search --draws 4 --stones 1 --generated 2 --scans none --paper 0 --stand 0.1";

/// A result as data, without what the host's clock measured.
json tables_without_times(const std::string& text) {
  json result = json::parse(text);
  for (json& table : result["tables"])
    for (json& row : table["rows"])
      for (const char* key :
           {"cpu_s_each", "wall_s_each", "cpu_s", "candidates_per_s", "wall_s", "cpu_s_a_stone"})
        row.erase(key);
  return result;
}

class MpiBench : public MpiCommand {
 protected:
  [[nodiscard]] static std::string bench(const std::string& out, const std::string& options,
                                         const std::string& arguments) {
    return concat("bench --out ", out, ' ', options, " --program ", STONESTACK_BENCH_BINARY, " -- ",
                  arguments);
  }
  [[nodiscard]] Outcome bench_alone(const std::string& arguments) const {
    return shell(concat("cd ", folder_, " && ", STONESTACK_BENCH_BINARY, ' ', arguments, " 2>err"));
  }
};

TEST_F(MpiBench, PartsOfAnyNumberOfRanksGiveTheTablesOfOneProcess) {
  const Outcome whole = bench_alone(kSearch + " --json");
  ASSERT_EQ(whole.code, 0) << whole.err;
  for (const int ranks : {1, 3}) {
    const std::string out = concat("parts-", ranks);
    const Outcome dealt = run_on(ranks, bench(out, "--parts 3 --json --record tables.json", kSearch));
    ASSERT_EQ(dealt.code, 0) << dealt.err;
    EXPECT_EQ(tables_without_times(dealt.out).dump(1), tables_without_times(whole.out).dump(1)) << ranks;
    EXPECT_EQ(json::parse(file("tables.json"))["benchmark"], "search");
    for (const char* line :
         {"part 1 of 3: performed on ", "part 2 of 3: ", "part 3 of 3: ", "3 of 3 are complete"})
      EXPECT_THAT(dealt.err, HasSubstr(line));
  }
}

TEST_F(MpiBench, GoesOnWithWhatItsFolderLacks) {
  ASSERT_EQ(run_on(2, bench("parts", "--parts 2", kSearch)).code, 0);
  expect_refused(run_on(2, bench("parts", "--parts 2", kSearch)), "holds parts already; --continue");
  expect_refused(run_on(2, bench("parts", "--parts 3 --continue", kSearch)), "none of 3 parts");

  // As the parts are after a process died in its second draw, and another before its first one.
  json begun = json::parse(file("parts/part-1-of-2.json"));
  const std::size_t draws = begun["draws"].size();
  ASSERT_GE(draws, 2U);
  begun["draws"].erase(draws - 1);
  begun["draws"][0]["outcome"]["of_default"]["reason"] = "as it was recorded";
  begun["complete"] = false;
  write("parts/part-1-of-2.json", begun.dump());
  fs::remove(folder_ + "/parts/part-2-of-2.json");
  const Outcome rest = run_on(2, bench("parts", "--parts 2 --continue", kSearch));
  ASSERT_EQ(rest.code, 0) << rest.err;
  const json ended = json::parse(file("parts/part-1-of-2.json"));
  ASSERT_EQ(ended["draws"].size(), draws);
  EXPECT_EQ(ended["draws"][0]["outcome"]["of_default"]["reason"], "as it was recorded") << "performed again";
  EXPECT_THAT(rest.err, HasSubstr("2 of 2 are complete"));

  const Outcome again = run_on(2, bench("parts", "--parts 2 --continue", kSearch));
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.err, testing::Not(HasSubstr("performed"))) << "all of it was there";
  EXPECT_THAT(again.out, HasSubstr("towers"));
}

TEST_F(MpiBench, SaysWhatABenchmarkRefused) {
  const Outcome refused = run_on(2, bench("parts", "--parts 2", "search --no-such-option"));
  EXPECT_EQ(refused.code, 3) << refused.err;
  EXPECT_THAT(refused.err, testing::AllOf(HasSubstr("ended with code 2: error: "),
                                          HasSubstr("--no-such-option"), HasSubstr("of-2.log")));
  const Outcome missing = run_on(2, "bench --out other --program nowhere/stonestack-bench -- " + kSearch);
  EXPECT_EQ(missing.code, 3) << missing.err;
  EXPECT_THAT(missing.err, HasSubstr("nowhere/stonestack-bench: is no program"));
  EXPECT_FALSE(fs::exists(folder_ + "/other"));
  expect_refused(run_on(2, "bench --out other"), "arguments");
  write("file", "");
  const Outcome no_folder = run_on(2, bench("file", "--parts 2", kSearch));
  EXPECT_EQ(no_folder.code, 3) << no_folder.err;
  EXPECT_THAT(no_folder.err, HasSubstr("file: is no folder"));
  const Outcome no_record = run_on(2, bench("parts", "--parts 2 --record file/tables.json", kSearch));
  EXPECT_EQ(no_record.code, 3) << no_record.err;
  EXPECT_THAT(no_record.err,
              testing::AllOf(HasSubstr("file/tables.json"), testing::Not(HasSubstr("performed"))));
}

/// Processes that work in that folder, by the name of their program.
std::set<pid_t> processes_of(const std::string& program, const std::string& folder) {
  std::set<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::error_code gone;
    if (fs::read_symlink(entry.path() / "cwd", gone) != fs::path(folder) || gone) continue;
    if (fs::read_symlink(entry.path() / "exe", gone).filename() == program && !gone)
      found.insert(std::stoi(entry.path().filename()));
  }
  return found;
}

TEST_F(MpiBench, AnInterruptEndsAllProcessesAndKeepsWhatTheyDid) {
  const std::string many = "search --draws 400 --stones 2 --generated 2 --scans none --paper 0 --stand 0.1";
  std::thread user([&] {  // as soon as both parts have kept a draw
    for (int i = 0; i < 2400; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      if (fs::exists(folder_ + "/parts/part-1-of-2.json") && fs::exists(folder_ + "/parts/part-2-of-2.json"))
        break;
    }
    for (const pid_t mpirun : processes_of("orterun", folder_)) ::kill(mpirun, SIGINT);
  });
  const Outcome stopped = run_on(2, bench("parts", "--parts 2", many));
  user.join();
  EXPECT_NE(stopped.code, 0) << stopped.err;
  for (int i = 0; i < 200 && !processes_of("stonestack-bench", folder_).empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(processes_of("stonestack-bench", folder_).empty()) << "a benchmark goes on without its rank";
  for (const char* part : {"parts/part-1-of-2.json", "parts/part-2-of-2.json"}) {
    const json kept = json::parse(file(part));
    EXPECT_GE(kept["draws"].size(), 1U) << part;
    EXPECT_LT(kept["draws"].size(), 200U) << part;
    EXPECT_EQ(kept["complete"], false) << part;
  }
}

}  // namespace
}  // namespace stonestack

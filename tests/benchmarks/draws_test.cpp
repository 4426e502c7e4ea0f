#include <set>
#include <string>

#include "bench_command.hpp"

namespace stonestack::bench {
namespace {

/// The document without what a clock measured.
json without_times(json result) {
  static const std::set<std::string> times{"cpu_s_each",       "wall_s_each", "cpu_s",
                                           "candidates_per_s", "wall_s",      "read_cpu_ms",
                                           "verdict_cpu_ms",   "all_cpu_ms",  "cpu_s_a_stone"};
  for (json& table : result["tables"])
    for (json& row : table["rows"])
      for (const std::string& key : times) row.erase(key);
  return result;
}

TEST_F(BenchCommand, ThreeShardsMergedGiveTheResultOfOneProcess) {
  for (const std::string arguments :
       {"search --draws 4 --stones 2 --generated 4 --scans none --paper 0 --stand 0.2 --seed 3 --ode",
        "detection --kinds isolated,few --scenes 2 --seed 5",
        "walls --draws 3 --stones 5 --courses 2+1 --generated 6 --scans none --friction 0.5 --stand 0.2"}) {
    const Outcome whole = run(arguments + " --json");
    ASSERT_EQ(whole.code, 0) << arguments << whole.err;
    std::set<int> performed;
    for (const int k : {1, 2, 3}) {
      const Outcome shard = run(concat(arguments, " --shard ", k, "/3 --record part-", k, ".json"));
      ASSERT_EQ(shard.code, 0) << arguments << shard.err;
      const json file = json::parse(read_file(concat(folder_, "/part-", k, ".json"), 1U << 24U));
      for (const json& draw : file["draws"]) {
        EXPECT_EQ((draw["number"].get<int>() - 1) % 3, k - 1);
        performed.insert(draw["number"].get<int>());
      }
    }
    EXPECT_GE(performed.size(), 3U) << "a shard had nothing to do";
    const std::string first_name = arguments.substr(0, arguments.find(' '));
    const Outcome merged = run(first_name + " --merge part-3.json part-1.json part-2.json --json");
    ASSERT_EQ(merged.code, 0) << arguments << merged.err;
    EXPECT_EQ(without_times(merged.data()).dump(1), without_times(whole.data()).dump(1)) << arguments;
  }
}

constexpr const char* kShortDraws =
    "search --draws 3 --stones 1 --generated 2 --scans none --paper 0 --stand 0.1";

TEST_F(BenchCommand, AMergeNamesWhatIsMissingAndAShardGoesOn) {
  ASSERT_EQ(run(concat(kShortDraws, " --shard 1/2 --record one.json")).code, 0);
  const Outcome part = run("search --merge one.json --json");
  EXPECT_EQ(part.code, 3);
  EXPECT_THAT(part.err, HasSubstr("lacks the draws 2, 4"));
  EXPECT_EQ(part.data()["complete"], false);

  // As a shard leaves it that was killed in its first draw but one.
  json begun = json::parse(read_file(folder_ + "/one.json", 1U << 24U));
  const json all = begun["draws"];
  ASSERT_EQ(all.size(), 2U);
  begun["draws"].erase(1);
  begun["draws"][0]["outcome"]["of_default"]["reason"] = "as it was recorded";
  write_file(folder_ + "/one.json", begun.dump());
  const Outcome rest = run(concat(kShortDraws, " --shard 1/2 --record one.json --continue"));
  ASSERT_EQ(rest.code, 0) << rest.err;
  const json after = json::parse(read_file(folder_ + "/one.json", 1U << 24U));
  ASSERT_EQ(after["draws"].size(), 2U);
  EXPECT_EQ(after["draws"][0]["outcome"]["of_default"]["reason"], "as it was recorded") << "performed again";
  EXPECT_EQ(after["draws"][1]["number"], all[1]["number"]);
}

TEST_F(BenchCommand, AMergeRefusesWhatDoesNotBelongTogether) {
  ASSERT_EQ(run(concat(kShortDraws, " --shard 1/2 --record one.json")).code, 0);
  ASSERT_EQ(run(concat(kShortDraws, " --seed 8 --shard 2/2 --record other.json")).code, 0);
  write_file(folder_ + "/result.json", "{\"schema\": \"stonestack.bench/1\", \"benchmark\": \"search\"}");
  expect_refusal("search --merge one.json other.json", 3, {"other.json", "--seed=8"});
  expect_refusal("search --merge one.json one.json", 3, {"draw 1 is there twice"});
  expect_refusal("search --merge result.json", 3, {"is no shard of `search`"});
  json spoilt = json::parse(read_file(folder_ + "/one.json", 1U << 24U));
  spoilt["draws"][0]["outcome"] = "nothing";
  write_file(folder_ + "/spoilt.json", spoilt.dump());
  expect_refusal("search --merge spoilt.json", 3, {"draw 1 cannot be read"});
  spoilt["arguments"] = {1, 2};
  write_file(folder_ + "/spoilt.json", spoilt.dump());
  expect_refusal("search --merge spoilt.json", 3, {"spoilt.json", "`arguments` that are no list of texts"});
  spoilt.erase("arguments");
  write_file(folder_ + "/spoilt.json", spoilt.dump());
  expect_refusal("search --merge spoilt.json", 3, {"spoilt.json", "has no `arguments`"});
  write_file(folder_ + "/spoilt.json", "[1, 2]");
  expect_refusal("search --merge spoilt.json", 3, {"is no shard of `search`"});
  expect_refusal("walls --merge one.json", 3, {"is no shard of `walls`"});
  expect_refusal("search --draws 3 --merge one.json", 2, {"leave out --draws=3"});
  expect_refusal("search --shard 1/2", 2, {"--record"});
  expect_refusal("search --shard 3/2 --record x.json", 2, {"--shard expects I/N"});
}

TEST_F(BenchCommand, TheNextStoneIsPlannedOnAsManyAsAreAskedFor) {
  const Outcome bench =
      run("walls --growth 6,12 --scans none --generated 27 --stones 27 --friction 0.5 --plot plot.svg --json "
          "--set search.perturbations=0 --set search.verdict_seconds=0.5");
  ASSERT_EQ(bench.code, 0) << bench.err;
  const json rows = rows_of(bench.data(), "cost of the next stone");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["that_stand"], 6);
  EXPECT_EQ(rows[1]["that_stand"], 12);
  for (const json& row : rows) {
    EXPECT_EQ(row["planned"], 2);
    EXPECT_GT(row["cpu_s_a_stone"].get<double>(), 0.0);
  }
  EXPECT_THAT(read_file(folder_ + "/plot.svg", 1U << 20U), HasSubstr("</svg>"));
}

TEST_F(BenchCommand, WallsAreBuiltBesideTheirPlanAndStonesThatFallAreCounted) {
  const std::string walls =
      "walls --draws 2 --generated 4 --scans none --stones 4 --courses 2+1 --friction 0.3 --stand 0.2 ";
  const Outcome small = run(walls + "--noise 3 --noise-turn 4 --take-off 2 --json");
  ASSERT_EQ(small.code, 0) << small.err;
  const json row = rows_of(small.data(), "walls")[0];
  EXPECT_GT(row["mean_stones"].get<double>(), 1.0);
  EXPECT_EQ(small.data()["settings"]["noise_mm"], 3.0);
  EXPECT_EQ(small.data()["settings"]["take_off"], 2);
  const Outcome again = run(walls + "--noise 3 --noise-turn 4 --take-off 2 --json");
  EXPECT_EQ(without_times(again.data()).dump(), without_times(small.data()).dump());
  const json exact = rows_of(run(walls + "--json").data(), "walls")[0];
  EXPECT_NE(exact["flatness_mm"], row["flatness_mm"]) << "the wall that was planned";
  // 40 mm are further than a stone may come to rest from its place.
  const Outcome wild = run(walls + "--noise 40 --noise-turn 20 --json");
  ASSERT_EQ(wild.code, 0) << wild.err;
  EXPECT_LT(rows_of(wild.data(), "walls")[0]["whole"].get<int>(), 2);
  EXPECT_THAT(wild.err, HasSubstr("4 fell"));
}

TEST_F(BenchCommand, TowersArePlannedWithModelsMadeOfViews) {
  const std::string towers =
      "search --draws 1 --stones 2 --generated 2 --scans none --stand 0.2 --friction 0.4 --seed 3 "
      "--set search.settled=6 ";
  const Outcome models = run(towers + "--paper 0 --attitudes 1,2 --json");
  ASSERT_EQ(models.code, 0) << models.err;
  EXPECT_EQ(models.data()["settings"]["attitudes"], "1,2");
  EXPECT_THAT(models.err, HasSubstr("limestone_0: modelled from 1 attitudes"));
  EXPECT_THAT(models.err, HasSubstr("limestone_1: modelled from "));
  EXPECT_GE(rows_of(models.data(), "towers")[0]["mean_clean"].get<double>(), 1.0) << "one stands by itself";
  const Outcome scans = run(towers + "--paper 0 --json");
  EXPECT_EQ(scans.data()["settings"]["attitudes"], "scans");
  EXPECT_THAT(scans.err, testing::Not(HasSubstr("modelled")));
  expect_refusal(towers + "--attitudes 1", 2, {"--paper 0"});
  expect_refusal(towers + "--paper 0 --attitudes 0", 2, {"--attitudes"});
}

}  // namespace
}  // namespace stonestack::bench

#include <gmock/gmock.h>

#include <string>

#include "bench_command.hpp"

namespace stonestack::bench {
namespace {

using testing::HasSubstr;

/// StoneBench with one problem, a wall of three stones, and this library's answer.
class StoneBench : public BenchCommand {
 protected:
  void SetUp() override {
    BenchCommand::SetUp();
    ASSERT_EQ(run("problems --out bench --count 2 --stones 6").code, 0);
    json problems = json::parse(read_file(folder_ + "/bench/problems.json", 100000));
    ASSERT_EQ(problems["problems"].size(), 2U);
    ASSERT_EQ(problems["problems"][0]["name"], "tower-001");
    problems["problems"].erase(0);
    write_file(folder_ + "/bench/problems.json", problems.dump());
    ASSERT_EQ(run("solve bench --out answers").code, 0);
    answer_ = json::parse(read_file(folder_ + "/answers/wall-002.json", 100000));
  }

  /// The row of the wall.
  [[nodiscard]] json scored(const json& answer) const {
    write_file(folder_ + "/answers/wall-002.json", answer.dump());
    const Outcome bench = run("score bench answers --json");
    EXPECT_EQ(bench.code, 0) << bench.err;
    return rows_of(bench.data(), "scores")[0];
  }

  json answer_;
};

TEST_F(StoneBench, ScoresAnAnswerByBothEngines) {
  ASSERT_EQ(answer_["placements"].size(), 3U);
  const json whole = scored(answer_);
  EXPECT_EQ(whole["score"], 1.0) << whole;
  EXPECT_EQ(whole["in_bullet"], 3);
  EXPECT_EQ(whole["in_ode"], 3);

  json two = answer_;
  two["placements"].erase(2);
  EXPECT_NEAR(scored(two)["score"].get<double>(), 2.0 / 3.0, 1e-12);

  json beside = answer_;
  beside["placements"][2]["T_W_O"]["y"] = beside["placements"][2]["T_W_O"]["y"].get<double>() + 0.3;
  EXPECT_EQ(scored(beside)["score"], 0.0) << "a stone in the air falls";

  json twice = answer_;
  twice["placements"][2]["stone"] = twice["placements"][0]["stone"];
  EXPECT_THAT(scored(twice)["note"].get<std::string>(), HasSubstr("is placed twice"));

  json through = answer_;
  through["placements"][2]["T_W_O"]["z"] = through["placements"][2]["T_W_O"]["z"].get<double>() - 0.03;
  EXPECT_EQ(scored(through)["score"], 0.0);

  json stranger = answer_;
  stranger["placements"][0]["stone"] = "basalt";
  EXPECT_THAT(scored(stranger)["note"].get<std::string>(), HasSubstr("not a stone of the problem"));

  EXPECT_THAT(scored(json::object())["note"].get<std::string>(), HasSubstr("cannot be read"));
}

TEST_F(BenchCommand, ABridgeIsScoredByWhatSpansTheGapFromBothSides) {
  ASSERT_EQ(run("problems --out bench --count 5 --stones 8").code, 0);
  json problems = json::parse(read_file(folder_ + "/bench/problems.json", 100000));
  ASSERT_EQ(problems["problems"][4]["name"], "bridge-005");
  EXPECT_EQ(problems["problems"][4]["span"], 0.08);
  problems["problems"] = {problems["problems"][4]};
  write_file(folder_ + "/bench/problems.json", problems.dump());
  ASSERT_EQ(run("solve bench --out answers").code, 0);
  const std::string path = folder_ + "/answers/bridge-005.json";
  const json answer = json::parse(read_file(path, 100000));
  const auto scored = [&](const json& other) {
    write_file(path, other.dump());
    const Outcome bench = run("score bench answers --json");
    EXPECT_EQ(bench.code, 0) << bench.err;
    return rows_of(bench.data(), "scores")[0];
  };
  ASSERT_GE(answer["placements"].size(), 3U);
  EXPECT_EQ(scored(answer)["score"], 1.0) << scored(answer);
  json piers = answer;
  piers["placements"].erase(piers["placements"].size() - 1);
  EXPECT_LT(scored(piers)["score"], 1.0);
  json aside = answer;  // the whole bridge moved: a pier stands in the gap
  for (json& placed : aside["placements"]) placed["T_W_O"]["x"] = placed["T_W_O"]["x"].get<double>() + 0.07;
  EXPECT_EQ(scored(aside)["score"], 0.0);
  EXPECT_THAT(scored(aside)["note"].get<std::string>(), HasSubstr("stands in the gap"));
}

}  // namespace
}  // namespace stonestack::bench

#include "benchmarks/result_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

using nlohmann::json;

void fill(Results& results) {
  results.settings({{"poses", 12}, {"friction", 0.3}});
  results.table("robots", {{"robot"}, {"solved"}, {"plan_ms_median", 1}, {"residual_max", -1}});
  results.row({"ur10", 3, 1.25, 2.5e-10});
  results.row({"ur5", true, std::numeric_limits<double>::quiet_NaN(), TableValue()});
  results.note("drawn again: %d", 4);
  results.figures("time", {{"cpu_s", 61.44, 1}});
}

TEST(ResultTable, WritesTheSameFiguresAsData) {
  std::ostringstream out, notes;
  Results results("made_up", {true, "0.1.0"}, out, notes);
  fill(results);
  EXPECT_EQ(out.str(), "") << "data are one document";
  EXPECT_EQ(notes.str(), "drawn again: 4\n");
  results.finish(true);
  const json found = json::parse(out.str());
  EXPECT_EQ(found["schema"], "stonestack.bench/1");
  EXPECT_EQ(found["benchmark"], "made_up");
  EXPECT_EQ(found["version"], "0.1.0");
  EXPECT_EQ(found["complete"], true);
  EXPECT_EQ(found["settings"], json({{"poses", 12}, {"friction", 0.3}}));
  ASSERT_EQ(found["tables"].size(), 2u);
  const json& robots = found["tables"][0];
  EXPECT_EQ(robots["name"], "robots");
  EXPECT_EQ(robots["columns"], json({"robot", "solved", "plan_ms_median", "residual_max"}));
  EXPECT_EQ(robots["rows"][0],
            json({{"robot", "ur10"}, {"solved", 3}, {"plan_ms_median", 1.25}, {"residual_max", 2.5e-10}}));
  EXPECT_EQ(
      robots["rows"][1],
      json({{"robot", "ur5"}, {"solved", true}, {"plan_ms_median", nullptr}, {"residual_max", nullptr}}));
  EXPECT_EQ(found["tables"][1]["rows"], json::array({{{"cpu_s", 61.44}}}));
}

TEST(ResultTable, PrintsEachLineAsSoonAsItIsKnown) {
  std::ostringstream out, notes;
  Results results("made_up", {false, "0.1.0"}, out, notes);
  fill(results);
  EXPECT_EQ(out.str(),
            "poses 12, friction 0.3\n"
            "\n"
            "robots\n"
            "robot          solved  plan ms median  residual max\n"
            "ur10                3             1.2       2.5e-10\n"
            "ur5               yes               -             -\n"
            "drawn again: 4\n"
            "\n"
            "time\n"
            "  cpu s         61.4\n");
  const std::string before = out.str();
  results.finish(true);
  EXPECT_EQ(out.str(), before);
  EXPECT_EQ(notes.str(), "");
}

TEST(ResultTable, ReportsABenchmarkThatDidNotEnd) {
  std::ostringstream out, notes;
  Results results("made_up", {true, "0.1.0"}, out, notes);
  fill(results);
  results.finish(false);
  const json found = json::parse(out.str());
  EXPECT_EQ(found["complete"], false);
  EXPECT_EQ(found["tables"][0]["rows"].size(), 2u) << "rows that were measured are kept";
}

TEST(ResultTable, RefusesARowThatDoesNotFit) {
  std::ostringstream out, notes;
  Results results("made_up", {true, "0.1.0"}, out, notes);
  results.table("robots", {{"robot"}, {"solved"}});
  EXPECT_THROW(results.row({"ur10"}), InvalidArgument);
  EXPECT_THROW(results.row({"ur10", 1, 2}), InvalidArgument);
  results.figures("time", {{"cpu_s", 1.0}});
  EXPECT_THROW(results.row({"ur10", 1}), InvalidArgument) << "the table before the figures has ended";
}

}  // namespace
}  // namespace stonestack::bench

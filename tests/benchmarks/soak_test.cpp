#include "bench_command.hpp"

namespace stonestack::bench {
namespace {

TEST_F(BenchCommand, SoakCountsWhatTheProcessHoldsAfterEachRun) {
  const Outcome done =
      run("soak --runs 2 --per-run 1 --seed 5 --json --set search.perturbations=0 --set "
          "run.measure_friction=false "
          "--scratch .");
  ASSERT_EQ(done.code, 0) << done.err;
  const json rows = rows_of(done.data(), "runs");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1]["seed"], 6);
  EXPECT_EQ(rows[1]["height"], 1);
  EXPECT_GT(rows[1]["heap_mb"].get<double>(), 1.0);
  EXPECT_LT(rows[1]["heap_mb"].get<double>(), rows[0]["heap_mb"].get<double>() + 1.0) << "caches are empty";
  EXPECT_GT(rows[1]["resident_mb"].get<double>(), 10.0);
  EXPECT_GE(rows[1]["descriptors"].get<int>(), 3);
  EXPECT_GE(rows[1]["threads"].get<int>(), 1);
  const json growth = rows_of(done.data(), "growth after the warm-up");
  ASSERT_EQ(growth.size(), 4U);
  for (const json& row : growth) EXPECT_EQ(row["verdict"], "too few runs");
  const auto scratch = std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
  EXPECT_EQ(scratch, 1) << "beside the messages nothing is left";
  expect_refusal("soak", 2, {"--hours"});
}

}  // namespace
}  // namespace stonestack::bench

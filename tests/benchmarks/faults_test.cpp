#include "bench_command.hpp"

namespace stonestack::bench {
namespace {

TEST_F(BenchCommand, FaultsThatTellMostBreakNoInvariant) {
  const Outcome done =
      run("faults --only 'q not a number,force infinite,arm lost for ever,protective stop' --phase "
          "start-pose,pre-grasp,close,lift --json");
  ASSERT_EQ(done.code, 0) << done.err;
  const json totals = rows_of(done.data(), "totals");
  ASSERT_EQ(totals.size(), 1U);
  EXPECT_EQ(totals[0]["cells"], 16);
  EXPECT_EQ(totals[0]["all_invariants_kept"], 16) << rows_of(done.data(), "broken").dump(1);
}

TEST_F(BenchCommand, FaultsOfACarryBreakNoInvariant) {
  const Outcome done = run(
      "faults --only 'motion lost,stops without notice,zero,camera moved,disk full' --phase transfer --json");
  ASSERT_EQ(done.code, 0) << done.err;
  const json totals = rows_of(done.data(), "totals");
  ASSERT_EQ(totals.size(), 1U);
  EXPECT_EQ(totals[0]["cells"], 5);
  EXPECT_EQ(totals[0]["all_invariants_kept"], 5) << rows_of(done.data(), "broken").dump(1);
}

TEST_F(BenchCommand, FaultsThatAreNotFatalEndWithTheRightTower) {
  const Outcome done = run("faults --only 'stone slips 20 mm,stone moved,drift' --phase lift --json");
  ASSERT_EQ(done.code, 0) << done.err;
  const json totals = rows_of(done.data(), "totals");
  ASSERT_EQ(totals.size(), 1U);
  EXPECT_EQ(totals[0]["faults_that_are_not_fatal"], 3);
  EXPECT_EQ(totals[0]["of_these_ended_with_the_right_tower"], 3) << rows_of(done.data(), "not right").dump(1);
}

TEST_F(BenchCommand, FaultsOfTheHostBreakNoInvariant) {
  const Outcome done =
      run("faults --only 'asleep in a motion,asleep between motions,another run,nobody reads the output' "
          "--phase connect,lift --json");
  ASSERT_EQ(done.code, 0) << done.err;
  const json totals = rows_of(done.data(), "totals");
  ASSERT_EQ(totals.size(), 1U);
  EXPECT_EQ(totals[0]["cells"], 8);
  EXPECT_EQ(totals[0]["phase_not_reached"], 0);
  EXPECT_EQ(totals[0]["all_invariants_kept"], 8) << rows_of(done.data(), "broken").dump(1);
  EXPECT_EQ(totals[0]["of_these_ended_with_the_right_tower"], 4) << rows_of(done.data(), "not right").dump(1);
}

TEST_F(BenchCommand, FaultsEndAlikeWhereverTheRunsWereMade) {
  const std::string some =
      "faults --only 'stone moved,zero,interrupt' --phase connect,plan,transfer --threads 2 "
      "--json";
  const Outcome shared = run(some), whole = run(some + " --from-start");
  ASSERT_EQ(shared.code, 0) << shared.err;
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(rows_of(shared.data(), "totals")[0]["cells"], 9);
  EXPECT_EQ(shared.data()["tables"], whole.data()["tables"]);
}

TEST_F(BenchCommand, FaultsRefuseAnUnknownName) {
  expect_refusal("faults --only nonsense", 2, {"no such fault"});
}

}  // namespace
}  // namespace stonestack::bench

#include "bench_command.hpp"

namespace stonestack::bench {
namespace {

/// The runs of some faults: the totals, and the cells that are not as they should be.
class Faults : public BenchCommand {
 protected:
  struct Told {
    json totals;
    std::string broken, not_right;
  };
  Told told(const std::string& which) {
    const Outcome done = run("faults " + which + " --json");
    EXPECT_EQ(done.code, 0) << done.err;
    const json totals = rows_of(done.data(), "totals");
    EXPECT_EQ(totals.size(), 1U);
    return {totals.at(0), rows_of(done.data(), "broken").dump(1), rows_of(done.data(), "not right").dump(1)};
  }
};

TEST_F(Faults, OnesThatTellMostBreakNoInvariant) {
  const Told runs = told(
      "--only 'q not a number,force infinite,arm lost for ever,protective stop' --phase "
      "start-pose,pre-grasp,close,lift");
  EXPECT_EQ(runs.totals["cells"], 16);
  EXPECT_EQ(runs.totals["all_invariants_kept"], 16) << runs.broken;
}

TEST_F(Faults, OnesInACarryBreakNoInvariant) {
  const Told runs =
      told("--only 'motion lost,stops without notice,zero,camera moved,disk full' --phase transfer");
  EXPECT_EQ(runs.totals["cells"], 5);
  EXPECT_EQ(runs.totals["all_invariants_kept"], 5) << runs.broken;
}

TEST_F(Faults, OnesThatAreNotFatalEndWithTheRightTower) {
  const Told runs = told("--only 'stone slips 20 mm,stone moved,drift' --phase lift");
  EXPECT_EQ(runs.totals["faults_that_are_not_fatal"], 3);
  EXPECT_EQ(runs.totals["of_these_ended_with_the_right_tower"], 3) << runs.not_right;
}

TEST_F(Faults, OnesOfTheHostBreakNoInvariant) {
  const Told runs = told(
      "--only 'asleep in a motion,asleep between motions,another run,nobody reads the output' "
      "--phase connect,lift");
  EXPECT_EQ(runs.totals["cells"], 8);
  EXPECT_EQ(runs.totals["phase_not_reached"], 0);
  EXPECT_EQ(runs.totals["all_invariants_kept"], 8) << runs.broken;
  EXPECT_EQ(runs.totals["of_these_ended_with_the_right_tower"], 4) << runs.not_right;
}

TEST_F(Faults, EndAlikeWhereverTheRunsWereMade) {
  const std::string some =
      "faults --only 'stone moved,zero,interrupt' --phase connect,plan,transfer --threads 2 "
      "--json";
  const Outcome shared = run(some), whole = run(some + " --from-start");
  ASSERT_EQ(shared.code, 0) << shared.err;
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(rows_of(shared.data(), "totals")[0]["cells"], 9);
  EXPECT_EQ(shared.data()["tables"], whole.data()["tables"]);
}

TEST_F(Faults, RefuseAnUnknownName) {
  expect_refusal("faults --only nonsense", 2, {"no such fault"});
}

}  // namespace
}  // namespace stonestack::bench

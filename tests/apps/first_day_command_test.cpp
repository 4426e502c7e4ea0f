// The operator's side of a first day: dry run, step by step, slow, rearm.
#include "commands.hpp"

namespace stonestack {
namespace {

using ::testing::AllOf;
using ::testing::Not;

class FirstDayCommand : public Commands {
 protected:
  [[nodiscard]] json result(const std::string& run) const { return read(run + "/result.json"); }
  [[nodiscard]] json read(const std::string& name) const {
    return json::parse(read_file(folder_ + "/" + name, 1 << 24), nullptr, false);
  }
};

TEST_F(FirstDayCommand, DryRunShowsThePlanOfTheFirstStep) {
  const Outcome dry = run("run --robot ur10 --dry-run --seed 3 --per-run 2 --out dry --json");
  ASSERT_EQ(dry.code, 0) << dry.err;
  EXPECT_EQ(dry.data()["ended"], "planned");
  EXPECT_GE(dry.data()["planned"].size(), 6U);
  EXPECT_THAT(dry.err, AllOf(HasSubstr("step that would be done"), HasSubstr("move to limestone_"),
                             HasSubstr("dry run, nothing moved")));
  EXPECT_TRUE(fs::exists(folder_ + "/dry/report.html"));
  expect_refusal("run --dry-run --execute --cell lab.yaml", 2, {"--dry-run", "--execute"});
  expect_refusal("run --dry-run --step", 2, {"--dry-run", "--step"});
  expect_refusal("run --slow --full-speed", 2, {"--slow", "--full-speed"});
}

TEST_F(FirstDayCommand, StepsWaitForEnterAndStopWithoutInput) {
  const std::string small = "run --robot ur10 --seed 1 --per-run 1 --step --out ";
  const Outcome none = run(small + "none < /dev/null");
  EXPECT_EQ(none.code, 130) << none.err;
  EXPECT_THAT(none.err, AllOf(HasSubstr("next: move to a view: "), HasSubstr("tool up to 0."),
                              HasSubstr("Enter: go, q: stop")));
  EXPECT_EQ(result("none")["ended"], "interrupted");
  EXPECT_EQ(result("none")["seconds"]["motion"], 0.0) << "nothing has moved";
  const Outcome quits = shell(
      concat("cd ", folder_, " && printf '\\n\\n\\n\\nq\\n\\n' | ", program_, " ", small, "quits 2>err"));
  EXPECT_EQ(quits.code, 130) << quits.err;
  EXPECT_EQ(result("quits")["ended"], "interrupted");
  EXPECT_TRUE(fs::exists(folder_ + "/quits/report.html"));
  std::size_t asked = 0;
  for (auto at = quits.err.find("next: "); at != std::string::npos; at = quits.err.find("next: ", at + 1))
    ++asked;
  EXPECT_EQ(asked, 5U);
  const Outcome whole =
      shell(concat("cd ", folder_, " && yes '' | ", program_, " ", small, "whole --slow 2>err"));
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(result("whole")["ended"], "all_placed");
  EXPECT_THAT(whole.err,
              AllOf(HasSubstr("0.25 m/s at most, as --slow asks"), HasSubstr("next: close the fingers"),
                    HasSubstr("next: open the fingers"), testing::ContainsRegex("tool up to 0\\.2[45]")));
  EXPECT_THAT(whole.err, Not(testing::ContainsRegex("tool up to (0\\.2[6-9]|0\\.[3-9]|[1-9])")));
}

TEST_F(FirstDayCommand, CtrlCWorksWhileAStepWaits) {
  const std::string waiting =
      interrupted_at(folder_, "run --robot ur10 --seed 1 --per-run 1 --step --out run < pipe", "next: ");
  const Outcome ended = shell(concat("cd ", folder_, " && mkfifo pipe && { sleep 120 > pipe & sleeper=$!; ",
                                     waiting, "; kill $sleeper; }"));
  EXPECT_THAT(ended.out, HasSubstr("code 130")) << ended.err;
  EXPECT_EQ(result("run")["ended"], "interrupted");
}

TEST_F(FirstDayCommand, SetupSaysWhatItNeedsAndWritesNothingWithoutIt) {
  expect_refusal("setup lab.yaml < /dev/null", 2, {"--address"});
  expect_refusal("setup lab.yaml --address 127.0.0.1 < /dev/null", 2, {"--gripper-address"});
  expect_refusal("setup lab.yaml --address 127.0.0.1 --gripper claw", 2, {"claw", "robotiq-2f-85"});
  expect_refusal("setup lab.txt --address 127.0.0.1 --gripper robotiq-2f-85", 2, {"lab.txt", ".yaml"});
  expect_refusal("setup lab.yaml --address 127.0.0.200 --gripper robotiq-2f-85", 6, {"127.0.0.200:29999"});
  EXPECT_FALSE(fs::exists(folder_ + "/lab.yaml"));
  write("lab.yaml", "robot: ur10\n");
  expect_refusal("setup lab.yaml --address 127.0.0.1 --gripper robotiq-2f-85", 3, {"lab.yaml", "--force"});
}

TEST_F(FirstDayCommand, RearmRefusesWithoutACell) {
  expect_refusal("rearm", 2, {"CELL"});
  expect_refusal("rearm nowhere.yaml", 3, {"nowhere.yaml"});
  write("lab.yaml", "arm: {address: 127.0.0.1, dashboard_port: 1}\n");
  expect_refusal("rearm lab.yaml", 6, {"127.0.0.1:1"});
}

TEST_F(FirstDayCommand, SetupAndRearmAnswerInJson) {
  write("served.yaml",
        "simulate: true\nsimulators:\n"
        "  arm: {address: 127.0.31.7, standard_ports: true, faults: {protective_stop_at: 0}}\n");
  const Outcome ended = shell(concat(
      "cd ", folder_, " && { ", program_,
      " simulate --cell served.yaml --only arm --per-run 1 --seconds 120 >served 2>served_err & server=$!; ",
      "for i in $(seq 600); do grep -q 'UR controller' served && break; sleep 0.1; done; ", program_,
      " setup lab.yaml --address 127.0.31.7 --gripper robotiq-2f-85 --json >setup.json 2>err && ", program_,
      " rearm lab.yaml --yes --json >rearm.json 2>>err; code=$?; kill -INT $server; wait $server; "
      "(exit $code); }"));
  ASSERT_EQ(ended.code, 0) << ended.err;
  const json setup = read("setup.json"), rearm = read("rearm.json");
  EXPECT_EQ(setup.value("schema", ""), "stonestack.setup/1") << setup;
  EXPECT_EQ(setup.value("cell", ""), "lab.yaml");
  EXPECT_EQ(setup.value("robot", ""), "ur10");
  EXPECT_TRUE(setup.contains("notes"));
  EXPECT_EQ(rearm.value("schema", ""), "stonestack.rearm/1") << rearm;
  EXPECT_EQ(rearm["before"].value("safety", ""), "PROTECTIVE_STOP");
  EXPECT_EQ(rearm["after"].value("safety", ""), "NORMAL");
  EXPECT_THAT(rearm["steps"], testing::Contains("unlock the protective stop"));
  EXPECT_THAT(ended.err, AllOf(HasSubstr("lab.yaml is written"), HasSubstr("motions are allowed")))
      << "what a person reads is on stderr then";
}

}  // namespace
}  // namespace stonestack

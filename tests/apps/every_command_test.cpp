// Every subcommand has help with an example, one JSON object as its result, and one line for bad usage.
#include "commands.hpp"

#include <map>
#include <regex>

namespace stonestack {
namespace {

using EveryCommand = Commands;

/// The commands that the help lists below "Subcommands:".
std::vector<std::string> listed_commands(const std::string& help) {
  std::vector<std::string> names;
  const std::size_t begin = help.find("Subcommands:");
  if (begin == std::string::npos) return names;
  const std::string list = help.substr(begin, help.find("\n\n", begin) - begin);
  const std::regex name("\n  (\\w+) ");
  for (auto it = std::sregex_iterator(list.begin(), list.end(), name); it != std::sregex_iterator(); ++it)
    names.push_back((*it)[1]);
  return names;
}

TEST_F(EveryCommand, HasHelpWithAnExample) {
  const auto commands = listed_commands(run("--help").out);
  ASSERT_GE(commands.size(), 15u);
  for (std::string command : commands) {
    if (command == "config") command = "config show";
    const Outcome help = run(command + " --help");
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_EQ(help.err, "") << command;
    for (const std::string& part :
         std::vector<std::string>{"Usage: stonestack " + command, "Example", "  stonestack "})
      EXPECT_THAT(help.out, HasSubstr(part)) << command;
  }
}

TEST_F(EveryCommand, OffersJsonAndLoudness) {
  for (const std::string& command : listed_commands(run("--help").out)) {
    if (command == "config" || command == "completion")
      continue;  // `config show` does; the other is a script
    const std::string help = run(command + " --help").out;
    for (const char* option : {"--json", "-q,--quiet", "-v,--verbose"})
      EXPECT_THAT(help, HasSubstr(option)) << command;
  }
}

TEST_F(EveryCommand, RefusesBadUsageWithExitCode2) {
  for (const std::string& command : listed_commands(run("--help").out)) {
    expect_refusal(command + " --no-such-option", 2, {"stonestack " + command, "--no-such-option"});
    expect_refusal(command + " --jsno", 2, {"--jsno"});
  }
  for (const std::string& command : listed_commands(run("config --help").out))
    expect_refusal("config " + command + " --no-such-option", 2, {"config " + command, "--no-such-option"});
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"scan", "--catalogue"},
      {"render", "--out"},
      {"detect", "SCENE"},
      {"segment", "SCENE"},
      {"track", "SCENE"},
      {"check --friction -1 x.yaml", "--friction"},
      {"plan", "SCENE"},
      {"run --per-run 0", "--per-run"},
      {"run --per-run 50", "give --per-run 6 at most, or make more with `stonestack scan --generate`"},
      {"run --seed abc", "error: stonestack run: --seed: "},
      {"run --wall 3+2+1 --per-run 4",
       "--wall 3+2+1 asks for 6 stones, 4 lie in the field; give --per-run 6"},
      {"run --method best", "--method"},
      {"run --view-port 80", "--view"},
      {"run -q -v", "--quiet"},
      {"run --wall 4+x", "--wall '4+x': '4+' is not a number; expected 4+3+2+1"},
      {"run --bridge abc", "--bridge 'abc'"},
      {"config shwo", "did you mean show"},
      {"decide", "error: stonestack decide: STATE is required; `stonestack decide --help`"},
      {"inspect", "RUN is required"},
      {"replay", "RUN is required"},
      {"calibrate", "give a file of stations, --capture CELL, --table CELL or --simulate N"},
      {"search", "--stones"},
      {"experiment --runs none", "--runs"},
      {"simulate --only lamp", "--only"},
      {"doctor --frames 1", "--frames"},
      {"record", "--out"},
      {"rearm", "CELL"},
      {"setup", "CELL"},
      {"view --joints 1", "q1,q2"},
      {"completion tcsh", "SHELL"},
      {"config", "error: stonestack config: A subcommand is required"},
      {"search --levels 0", "--levels"},
      {"search --set search.frictoin=0.3", "did you mean search.friction"},
      {"detect x.png --set search.friction=0.3", "this command has no option search.friction"},
      {"check x.yaml --set search.friction=0.3", "stonestack check has no option '--set'"},
      {"config show --set search.friction=9", "search.friction must be in"},
  };
  for (const auto& [arguments, part] : wrong) expect_refusal(arguments, 2, {part});
  expect_refusal("run --wall nowhere.yaml", 3, {"nowhere.yaml"});
  EXPECT_FALSE(fs::exists(folder_ + "/runs")) << "what is refused leaves no folder";
}

TEST_F(EveryCommand, ErrorsOfInputNameTheRemedy) {
  write("cell.yaml", "robot: ur10\narm: {address: 127.0.0.1}\n");
  fs::create_directories(folder_ + "/empty/run");
  ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1").code, 0);
  const std::vector<std::tuple<std::string, int, std::string>> wrong = {
      {"check " + data_path("targets/wall.yaml"), 3,
       "give a stonestack.scene/1 file, as `search --out` writes"},
      {"run --target " + data_path("stones/limestone_1/stone.yaml"), 3, "give a stonestack.target/1 file"},
      {"calibrate " + data_path("targets/wall.yaml"), 3, "give a stonestack.hand_eye/1 file"},
      {"replay empty/run", 3, "record one with `run --set run.save_states=true`"},
      {"run --robot nope", 3, "or the path of a URDF or YAML"},
      {"detect empty", 3, "it must contain scene_camera.json (BOP)"},
      {"detect scene/cloud.ply --units mm", 4, "is --units right?"},
  };
  for (const auto& [arguments, code, part] : wrong) expect_refusal(arguments, code, {part});
  EXPECT_THAT(run("doctor --cell cell.yaml").out,
              HasSubstr("force_torque.device: is missing; give its path"));
  EXPECT_THAT(run("config --help").out, HasSubstr("stonestack config show\n  stonestack config init"));
  EXPECT_THAT(run("experiment --help").out, HasSubstr("Number of runs"));
}

/// Which command each schema is from (docs/formats.md). The slow ones have tests of their own: `run` and
/// `experiment` in run_record_test.cpp and experiment_command_test.cpp, `calibrate`, `doctor` and `decide` in
/// theirs.
TEST_F(EveryCommand, SpeaksJsonOnStdoutAlone) {
  ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1,limestone_4").code, 0);
  const std::vector<std::pair<std::string, std::string>> schemas = {
      {"scan --generate 1 --catalogue made --json", "stonestack.scan/1"},
      {"render --out again --stones limestone_1 --json", "stonestack.render/1"},
      {"detect scene/scene.yaml --json", "stonestack.detect/1"},
      {"segment scene/scene.yaml --json", "stonestack.segment/1"},
      {"track scene/scene.yaml --expect scene/scene.yaml --json", "stonestack.track/1"},
      {"search --stones limestone_1,limestone_2 --json --set search.rounds=1", "stonestack.search/1"},
      {"record --frames 1 --per-run 1 --out views --json", "stonestack.record/1"},
      {"config show --json", "stonestack.config/1"},
      {"config cell --json", "stonestack.config/1"},
  };
  for (const auto& [arguments, schema] : schemas) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.data().value("schema", ""), schema) << arguments << "\n" << outcome.out;
  }
}

TEST_F(EveryCommand, PrintsItsResultOnStdoutWithoutJsonToo) {
  ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1,limestone_4 -q").code, 0);
  EXPECT_THAT(run("scan --generate 1 --catalogue made -q").out, HasSubstr("limestone_1"));
  const Outcome found = run("detect scene/scene.yaml -q");
  EXPECT_THAT(found.out, HasSubstr("limestone_4"));
  EXPECT_EQ(found.err, "");
  const Outcome built = run("run --robot ur10 --seed 1 --per-run 1 --out record --set run.save_states=true");
  EXPECT_EQ(built.code, 0) << built.err;
  EXPECT_THAT(built.out, HasSubstr("tower of 1 of 1 stones; ended: "));
  EXPECT_THAT(built.out, HasSubstr("report:  record/report.html"));
  EXPECT_THAT(built.err, ::testing::Not(HasSubstr("ended: ")));
  EXPECT_THAT(built.err, HasSubstr("tower: 1 of 1 stones"));
  EXPECT_THAT(run("inspect record").out, HasSubstr("\nend (all_placed): "));
  EXPECT_EQ(run("inspect record --json").data().value("schema", ""), "stonestack.inspect/1");
  const Outcome replayed = run("replay record -q");
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr("the same: "));
  EXPECT_EQ(run("replay record --json -q").data().value("schema", ""), "stonestack.replay/1");
  EXPECT_EQ(run("replay scene").code, 3) << "no run";
  EXPECT_EQ(run("decide record/state-001.json --json").data().value("schema", ""), "stonestack.decision/1");
  const json files = run("export record --to ply --out tower --json").data();
  EXPECT_EQ(files.value("schema", ""), "stonestack.export/1");
  EXPECT_EQ(files.value("files", json::array()).size(), 1U);
}

TEST_F(EveryCommand, VerboseLogsEveryEvent) {
  const Outcome loud = run("run --robot ur10 --seed 1 --per-run 1 --out record -v --json");
  EXPECT_EQ(loud.code, 0) << loud.err;
  EXPECT_THAT(loud.err, HasSubstr("debug: "));
  EXPECT_EQ(loud.data()["schema"], "stonestack.run/1");
  EXPECT_THAT(loud.err, HasSubstr("tower of 1 of 1 stones; ended: ")) << "the table for a person";
}

TEST_F(EveryCommand, ProgressIsOneLineInPlaceOnATerminal) {
  const std::string arguments = "scan --generate 2 --catalogue made";
  const std::string shown = on_terminal("-u NO_COLOR TERM=xterm", arguments);
  EXPECT_THAT(shown, HasSubstr("\r\x1b[2Kscan: 0 of 2 stones"));
  EXPECT_THAT(shown, HasSubstr("\r\x1b[2Kscan: 1 of 2 stones"));
  EXPECT_THAT(shown, ::testing::ContainsRegex("1 of 2 stones, now limestone_2, about [0-9]+ s left"));
  EXPECT_THAT(on_terminal("TERM=dumb", arguments + " --force"), ::testing::Not(HasSubstr("\x1b[2K")));
  const Outcome plain = run(arguments + " --force");
  EXPECT_THAT(plain.err, HasSubstr("info: scan: 1 of 2 stones"));
  EXPECT_THAT(plain.err, ::testing::Not(HasSubstr("\x1b")));
  EXPECT_THAT(run(arguments + " --force -q").err, ::testing::Not(HasSubstr("scan:")));
}

TEST_F(EveryCommand, ConfigInitWritesAFileThatChangesNothing) {
  const std::string before = run("config show --expert").out;
  for (const std::string more : {"", " --expert --force"}) {
    EXPECT_EQ(run("config init" + more).code, 0);
    EXPECT_EQ(run("config show --expert").out, before) << "every line is a comment";
  }
  expect_refusal("config init", 2, {"stonestack.yaml is there already", "--force"});
  std::string text = read_file(folder_ + "/stonestack.yaml", 1 << 20);
  const std::string line = "\n#search.friction: ";
  const std::size_t at = text.find(line);
  ASSERT_NE(at, std::string::npos) << text;
  write("stonestack.yaml", text.erase(at + 1, 1));
  EXPECT_EQ(run("config show").out, run("config show --set search.seed=1").out);
  write("stonestack.yaml", "search.frictoin: 0.3\n");
  expect_refusal("config show", 3, {"stonestack.yaml", "did you mean search.friction"});
}

TEST_F(EveryCommand, OriginsFollowTheirPrecedence) {
  write("user/stonestack/config.yaml", "search.friction: 0.2\nsearch.beam: 5\nrun.max_failures: 2\n");
  write("stonestack.yaml", "search.friction: 0.25\nsearch.beam: 6\n");
  program_ = "env XDG_CONFIG_HOME=user STONESTACK_SEARCH_FRICTION=0.3 STONESTACK_SERCH_BEAM=3 " + program_;
  const Outcome shown = run("config show --origin --expert --set search.min_margin=0.02");
  EXPECT_EQ(shown.code, 0);
  EXPECT_THAT(shown.out, HasSubstr("search.friction: 0.3  # environment STONESTACK_SEARCH_FRICTION\n"));
  EXPECT_THAT(shown.out, HasSubstr("search.beam: 6  # project file stonestack.yaml\n"));
  EXPECT_THAT(shown.out, HasSubstr("run.max_failures: 2  # user file user/stonestack/config.yaml\n"));
  EXPECT_THAT(shown.out, HasSubstr("search.min_margin: 0.02  # flag --set\n"));
  EXPECT_THAT(shown.out, HasSubstr("search.method: default  # default\n"));
  EXPECT_THAT(shown.err, HasSubstr("STONESTACK_SERCH_BEAM sets no option of this command; did you mean "
                                   "STONESTACK_SEARCH_BEAM?"));
  EXPECT_THAT(shown.err, ::testing::Not(HasSubstr("STONESTACK_SEARCH_FRICTION ")));
}

}  // namespace
}  // namespace stonestack

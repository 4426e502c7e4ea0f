// What every subcommand has in common: how it is called, and where its output goes.
#include "commands.hpp"

namespace stonestack {
namespace {

using ::testing::Not;
using CommandLine = Commands;

TEST_F(CommandLine, SuggestsWhatMayHaveBeenMeant) {
  expect_refusal("serch", 2, {"unknown command 'serch'; did you mean search?"});
  expect_refusal("config shw", 2, {"unknown command 'shw' of stonestack config; did you mean show?"});
  expect_refusal("frobnicate", 2, {"unknown command 'frobnicate'; commands: scan"});
  expect_refusal("run --robt ur10", 2, {"stonestack run has no option '--robt'; did you mean --robot?"});
  expect_refusal("run --cat=rocks", 2, {"no option '--cat'; did you mean --catalogue?"});
  expect_refusal("check --pictur a.png", 2, {"did you mean --picture?"});
  expect_refusal("--versoin", 2, {"stonestack has no option '--versoin'; did you mean --version?"});
  expect_refusal("run --frobnicate", 2, {"no option '--frobnicate'; `stonestack run --help`"});
  expect_refusal("run ur10", 2, {"stonestack run has no use for 'ur10'"});
}

TEST_F(CommandLine, HelpIsASubcommand) {
  for (const std::string command : {"", "run", "config show"}) {
    const Outcome help = run("help " + command);
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_EQ(help.out, run(command + " --help").out);
    EXPECT_THAT(help.out, HasSubstr("Usage"));
  }
  expect_refusal("help serch", 2, {"did you mean search?"});
}

TEST_F(CommandLine, ALostOutputIsAnError) {
  for (const std::string arguments : {"--version", "--help", "config show", "config cell --json"})
    for (const std::string to : {" >/dev/full", " >&-"}) {
      const Outcome lost = run(arguments + to);
      EXPECT_EQ(lost.code, 3) << arguments << to;
      EXPECT_THAT(lost.err, HasSubstr("stdout: cannot be written: ")) << arguments << to;
    }
  EXPECT_EQ(run("config shw >&-").code, 2) << "the first error counts";
  EXPECT_EQ(run("run --execute >&-").code, 2) << "nothing was printed, nothing is lost";
  EXPECT_EQ(run("--version <&-").code, 0);
  EXPECT_EQ(run("--version >/dev/null").code, 0);
}

TEST_F(CommandLine, ColoursOnATerminalUnlessTheUserWantsNone) {
  EXPECT_THAT(on_terminal("-u NO_COLOR TERM=xterm", "frobnicate"), HasSubstr("\x1b["));
  const std::string plain = on_terminal("NO_COLOR=1 TERM=xterm", "frobnicate");
  EXPECT_THAT(plain, HasSubstr("error: unknown command"));
  EXPECT_THAT(plain, Not(HasSubstr("\x1b[")));
}

TEST_F(CommandLine, ConfigSpeaksJson) {
  write("stonestack.yaml", "search:\n  friction: 0.3\n");
  const json shown = run("config show --expert --json").data();
  ASSERT_EQ(shown["schema"], "stonestack.config/1");
  const auto option = [](const json& data, const std::string& name) {
    for (const json& entry : data["options"])
      if (entry["name"] == name) return entry;
    return json();
  };
  const json friction = option(shown, "search.friction");
  EXPECT_EQ(friction["value"], 0.3);
  EXPECT_EQ(friction["origin"], "project file stonestack.yaml");
  EXPECT_EQ(friction["range"].size(), 2U);
  EXPECT_EQ(option(shown, "search.method")["value"], "default");
  EXPECT_EQ(option(shown, "simulation.sensor_noise")["value"], true);
  const Outcome text = run("config show --expert");
  EXPECT_EQ(static_cast<std::size_t>(std::count(text.out.begin(), text.out.end(), '\n')),
            shown["options"].size());
  EXPECT_LT(run("config show --json").data()["options"].size(), shown["options"].size());

  const json cell = run("config cell --expert --json").data();
  EXPECT_EQ(cell["schema"], "stonestack.config/1");
  EXPECT_EQ(option(cell, "arm.rtde_port")["value"], 30004);
  EXPECT_EQ(option(cell, "arm.rtde_port")["range"], json({0.0, 65535.0}));
}

}  // namespace
}  // namespace stonestack

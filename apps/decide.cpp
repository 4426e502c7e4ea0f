#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::apps {
namespace {

struct DecideCommand {
  DecisionTask task;
  bool json = false;
};

void decide_next(DecideCommand& command) {
  const DecisionReport report = decide(command.task);
  std::cout << (command.json ? report.json : report.text);
}

}  // namespace

void add_decide(CLI::App& app) {
  const auto [sub, command] = add_subcommand<DecideCommand>(
      app, "decide", "Print what a run would do next in a saved state, and why", decide_next);
  add_path(sub, "state", command.task.state, "File that `run --set run.save_states=true` wrote", "STATE.json")
      ->required();
  add_path(sub, "--catalogue", command.task.catalogue, "Stones (default: those of the state)", "DIR");
  sub.add_option("--robot", command.task.robot, "Robot (default: that of the state)");
  sub.add_option("--set", command.task.assignments, "Set an option instead of the state's")
      ->type_name("NAME=VALUE");
  sub.add_flag("--json", command.json, "Print one JSON object (schema stonestack.decision/1)");
  sub.footer(
      "Nothing moves: the state holds all that the decision depends on.\n"
      "Examples:\n"
      "  stonestack run --robot ur10 --seed 1 --out record --set run.save_states=true\n"
      "  stonestack decide record/state-002.json\n"
      "  stonestack decide record/state-002.json --json --set search.horizon=1");
}

}  // namespace stonestack::apps

#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::apps {
namespace {

struct DecideCommand {
  DecisionTask task;
  bool json = false;
  Loudness loudness;
};

void decide_next(DecideCommand& command) {
  command.loudness.apply();
  const DecisionReport report = decide(command.task);
  std::cout << (command.json ? report.json : report.text);
}

struct InspectCommand {
  std::string run;
  bool json = false;
  Loudness loudness;
};

void inspect(InspectCommand& command) {
  command.loudness.apply();
  const RunInspection found = inspect_run(command.run);
  std::cout << (command.json ? found.json : found.text);
}

struct ReplayCommand {
  ReplayTask task;
  bool json = false;
  Loudness loudness;
};

void replay(ReplayCommand& command) {
  command.loudness.apply();
  const Replay replayed = replay_run(command.task, [](const std::string& line) { log_info(line); });
  std::cout << (command.json ? replay_json(replayed) : replay_text(replayed));
  if (!replayed.difference.empty())
    throw Error("the decisions differ from those of the run", ExitCode::kExecutionFailed);
}

}  // namespace

void add_inspect(CLI::App& app) {
  const auto [sub, command] = add_subcommand<InspectCommand>(
      app, "inspect", "Print what happened in a run, by its journal, also of one that was killed", inspect);
  add_path(sub, "RUN", command.run, "Folder of a run", "DIR")->required();
  sub.add_flag("--json", command.json, "Print one JSON object (schema stonestack.inspect/1)");
  command.loudness.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack inspect runs/20250101-101500-seed1\n"
      "  stonestack inspect record --json");
}

void add_replay(CLI::App& app) {
  const auto [sub, command] = add_subcommand<ReplayCommand>(
      app, "replay", "Make a recorded run's decisions again and compare them; nothing moves", replay);
  add_path(sub, "RUN", command.task.run, "Folder of a run with `--set run.save_states=true`", "DIR")
      ->required();
  add_path(sub, "--catalogue", command.task.catalogue, "Stones (default: those of the run)", "DIR");
  add_path(sub, "--cell", command.task.cell, "Cell of the run, if it was performed in one", "FILE");
  sub.add_flag("--json", command.json, "Print one JSON object (schema stonestack.replay/1)");
  command.loudness.register_on(sub);
  sub.footer(
      "Every observation, decision, motion and outcome comes again from what the devices answered, to the\n"
      "last digit; another version of stonestack shows what it would have done otherwise.\n"
      "Examples:\n"
      "  stonestack run --robot ur10 --seed 1 --out record --set run.save_states=true\n"
      "  stonestack replay record\n"
      "  stonestack replay record --json -q");
}

void add_decide(CLI::App& app) {
  const auto [sub, command] = add_subcommand<DecideCommand>(
      app, "decide", "Print what a run would do next in a saved state, and why", decide_next);
  add_path(sub, "STATE", command.task.state, "File that `run --set run.save_states=true` wrote")->required();
  add_path(sub, "--catalogue", command.task.catalogue, "Stones (default: those of the state)", "DIR");
  sub.add_option("--robot", command.task.robot, "Robot (default: that of the state)");
  sub.add_option("--set", command.task.assignments, "Set an option instead of the state's")
      ->type_name("NAME=VALUE");
  sub.add_flag("--json", command.json, "Print one JSON object (schema stonestack.decision/1)");
  command.loudness.register_on(sub);
  sub.footer(
      "Nothing moves: the state holds all that the decision depends on.\n"
      "Examples:\n"
      "  stonestack run --robot ur10 --seed 1 --out record --set run.save_states=true\n"
      "  stonestack decide record/state-002.json\n"
      "  stonestack decide record/state-002.json --json --set search.horizon=1");
}

}  // namespace stonestack::apps

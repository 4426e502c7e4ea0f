#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stacking/state_file.hpp"

namespace stonestack::apps {
namespace {

struct DecideCommand {
  std::string state;
  std::string catalogue;  ///< empty: as the state says
  std::string robot;      ///< likewise
  std::vector<std::string> assignments;
  bool json = false;
};

void decide(DecideCommand& command) {
  const StateHeader header = read_state_header(command.state);
  const std::string stones = command.catalogue.empty() ? header.catalogue : command.catalogue;
  const Catalogue catalogue = read_catalogue(stones.empty() ? data_path("stones") : stones);
  const RobotModel robot = read_robot(command.robot.empty() ? header.robot : command.robot);
  State state = read_state(command.state, catalogue);
  for (const std::string& assignment : command.assignments) set_field(fields(state.options), assignment);
  const Models models = make_models(catalogue, robot, state.world.layout);
  add_resting_stacks(models, state.options, state.memory.friction, state.world);
  const Decision decision = choose_action(state.world, state.memory, models, state.options);
  std::cout << (command.json ? decision_json(decision, catalogue) : decision_text(decision, catalogue));
}

}  // namespace

void add_decide(CLI::App& app) {
  const auto [sub, command] = add_subcommand<DecideCommand>(
      app, "decide", "Print what a run would do next in a saved state, and why", decide);
  add_path(sub, "state", command.state, "File that `run --set run.save_states=true` wrote", "STATE.json")
      ->required();
  add_path(sub, "--catalogue", command.catalogue, "Stones (default: those of the state)", "DIR");
  sub.add_option("--robot", command.robot, "Robot (default: that of the state)");
  sub.add_option("--set", command.assignments, "NAME=VALUE, instead of the state's option");
  sub.add_flag("--json", command.json, "Print one JSON object (schema stonestack.decision/1)");
  sub.footer(
      "Nothing moves: the state holds all that the decision depends on.\n"
      "Examples:\n"
      "  stonestack run --robot ur10 --seed 1 --out record --set run.save_states=true\n"
      "  stonestack decide record/state-002.json\n"
      "  stonestack decide record/state-002.json --json --set search.horizon=1");
}

}  // namespace stonestack::apps

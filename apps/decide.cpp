#include <cstdio>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "settings.hpp"
#include "stonestack/core/error.hpp"
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

std::string pose_text(const Pose& pose) {
  const Eigen::Vector3d p = 1000 * pose.translation();
  char text[64];
  std::snprintf(text, sizeof text, "(%.0f %.0f %.0f) mm", p.x(), p.y(), p.z());
  return text;
}

/// An action and its alternatives, a line each.
struct Lines {
  const Models& models;

  [[nodiscard]] std::string candidates(const char* verb, const std::vector<Placement>& list) const {
    std::string text;
    for (const Placement& p : list)
      text +=
          concat(text.empty() ? verb : "  or", " ", models.name(p.stone), " at ", pose_text(p.T_W_O),
                 ", predicted success ", p.predicted_success, ", expected height ", p.expected_height, "\n");
    return text;
  }
  [[nodiscard]] std::string places(const std::string& start, const std::vector<Pose>& list) const {
    std::string text = start + "\n";
    for (const Pose& pose : list) text += "  to " + pose_text(pose) + "\n";
    return text;
  }
  std::string operator()(const Place& a) const { return candidates("place", a.candidates); }
  std::string operator()(const Reorient& a) const { return candidates("reorient", a.candidates); }
  std::string operator()(const Unstack& a) const {
    return places("unstack " + models.name(a.top.stone), a.T_W_O_down);
  }
  std::string operator()(const ClearBase& a) const {
    return places("clear the base of " + models.name(a.stray.stone), a.T_W_O_down);
  }
  std::string operator()(const LookAgain& a) const { return concat("look for ", models.name(a.stone), "\n"); }
  std::string operator()(const Stop& a) const { return "stop: " + a.reason + "\n"; }
};

void run(const DecideCommand& command) {
  const StateHeader header = read_state_header(command.state);
  const std::string stones = command.catalogue.empty() ? header.catalogue : command.catalogue;
  const Catalogue catalogue = read_catalogue(stones.empty() ? data_path("stones") : stones);
  const RobotModel robot = read_robot(command.robot.empty() ? header.robot : command.robot);
  State state = read_state(command.state, catalogue);
  for (const std::string& assignment : command.assignments) set_field(fields(state.options), assignment);
  const Models models = make_models(catalogue, robot, state.world.layout);
  add_resting_stacks(models, state.options, state.memory.friction, state.world);
  const Decision decision = choose_action(state.world, state.memory, models, state.options);
  if (command.json) {
    std::cout << decision_json(decision, catalogue);
    return;
  }
  std::cout << std::visit(Lines{models}, decision.action) << "why:\n";
  for (const Event& event : decision.why)
    if (const std::string line = to_text(event, catalogue); !line.empty()) std::cout << "  " << line << "\n";
}

}  // namespace

void add_decide(CLI::App& app) {
  auto command = std::make_shared<DecideCommand>();
  CLI::App* sub = app.add_subcommand("decide", "Print what a run would do next in a saved state, and why");
  sub->add_option("state", command->state, "File that `run --set run.save_states=true` wrote")
      ->required()
      ->type_name("STATE.json");
  sub->add_option("--catalogue", command->catalogue, "Stones (default: those of the state)")
      ->type_name("DIR");
  sub->add_option("--robot", command->robot, "Robot (default: that of the state)");
  sub->add_option("--set", command->assignments, "NAME=VALUE, instead of the state's option");
  sub->add_flag("--json", command->json, "Print one JSON object (schema stonestack.decision/1)");
  sub->footer(
      "Nothing moves: the state holds all that the decision depends on.\n"
      "Examples:\n"
      "  stonestack run --robot ur10 --seed 1 --out record --set run.save_states=true\n"
      "  stonestack decide record/state-002.json\n"
      "  stonestack decide record/state-002.json --json --set search.horizon=1");
  sub->callback([command] { run(*command); });
}

}  // namespace stonestack::apps

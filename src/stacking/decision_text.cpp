#include <cstdio>

#include "stacking/state_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::stacking {
namespace {

std::string in_millimetres(const Pose& pose) {
  const Eigen::Vector3d p = 1000 * pose.translation();
  char text[64];
  std::snprintf(text, sizeof text, "(%.0f %.0f %.0f) mm", p.x(), p.y(), p.z());
  return text;
}

/// An action and its alternatives, a line each.
struct ActionText {
  const Catalogue& catalogue;

  [[nodiscard]] const std::string& name(StoneIndex stone) const { return catalogue[stone].name; }
  [[nodiscard]] std::string candidates(const char* verb, const std::vector<Placement>& list) const {
    std::string text;
    for (const Placement& p : list)
      text +=
          concat(text.empty() ? verb : "  or", " ", name(p.stone), " at ", in_millimetres(p.T_W_O),
                 ", predicted success ", p.predicted_success, ", expected height ", p.expected_height, "\n");
    return text;
  }
  [[nodiscard]] static std::string places(const std::string& start, const std::vector<Pose>& list) {
    std::string text = start + "\n";
    for (const Pose& pose : list) text += "  to " + in_millimetres(pose) + "\n";
    return text;
  }
  std::string operator()(const Place& a) const { return candidates("place", a.candidates); }
  std::string operator()(const Reorient& a) const { return candidates("reorient", a.candidates); }
  std::string operator()(const Unstack& a) const {
    return places("unstack " + name(a.top.stone), a.T_W_O_down);
  }
  std::string operator()(const ClearBase& a) const {
    return places("clear the base of " + name(a.stray.stone), a.T_W_O_down);
  }
  std::string operator()(const Push& a) const {
    std::string text = "push " + name(a.stone.stone) + "\n";
    for (const Eigen::Vector2d& shift : a.p_W_shifts)
      text += concat("  by (", std::lround(1e3 * shift.x()), ", ", std::lround(1e3 * shift.y()), ") mm\n");
    return text;
  }
  std::string operator()(const LookAgain& a) const { return concat("look for ", name(a.stone), "\n"); }
  std::string operator()(const ModelAnew& a) const {
    std::string lost;
    for (const StoneIndex stone : a.lost) lost += (lost.empty() ? "" : ", ") + name(stone);
    if (a.in_sight) return concat("model ", lost, " as it stands: by its model it cannot\n");
    return concat("model what lies there and is not recognised; out of sight: ", lost, "\n");
  }
  std::string operator()(const Stop& a) const { return "stop: " + a.reason + "\n"; }
};

}  // namespace

std::string decision_text(const Decision& decision, const Catalogue& catalogue) {
  std::string text = std::visit(ActionText{catalogue}, decision.action) + "why:\n";
  for (const Event& event : decision.why)
    if (const std::string line = to_text(event, catalogue); !line.empty()) text += "  " + line + "\n";
  return text;
}

DecisionReport decide(const DecisionTask& task) {
  const StateHeader header = read_state_header(task.state);
  const std::string stones = task.catalogue.empty() ? header.catalogue : task.catalogue;
  const Catalogue catalogue = read_catalogue(stones.empty() ? data_path("stones") : stones);
  const RobotModel robot = read_robot(task.robot.empty() ? header.robot : task.robot);
  State state = read_state(task.state, catalogue);
  for (const std::string& assignment : task.assignments) set_field(fields(state.options), assignment);
  const Models models = make_models(catalogue, robot, state.world.layout, state.options.wall);
  add_resting_stacks(models, state.options, state.memory.friction, state.world);
  const Decision decision = choose_action(state.world, state.memory, models, state.options);
  return {decision_json(decision, catalogue), decision_text(decision, catalogue)};
}

}  // namespace stonestack::stacking

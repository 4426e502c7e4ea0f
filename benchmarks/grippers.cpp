// Prints what each gripper can hold: of every stone in each of its stable resting poses on a free table, how
// many of its grasps table and arm leave (a UR10, the stone in its field), and how many times the stone's
// weight the firmest of them bears.
#include <algorithm>
#include <memory>
#include <vector>

#include "bench.hpp"
#include "common_options.hpp"
#include "grasp_problems.hpp"
#include "motion/grasp/pad_press.hpp"
#include "motion/grasp_check.hpp"
#include "motion/regrasp.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::bench {
namespace {

constexpr std::size_t kPressed = 40;   // grasps of the best scores that are pressed
constexpr double kMaxWeights = 8.0;    // loads that are tried, in weights of the stone
constexpr double kPadSpacing = 0.003;  // m between samples of the surface

/// How a gripper got on with all stones.
struct GripperTally {
  int poses = 0, held = 0, stones = 0, stones_held = 0;
};

/// The firmest of the grasps by their scores: load that its pads bear, in weights.
double firmest(const Stone& stone, const PlanningScene& scene, const std::vector<const Grasp*>& grasps,
               const Pose& T_W_O) {
  const auto surface = sample_surface(stone.scan, kPadSpacing);
  double best = 0.0;
  for (std::size_t i = 0; i < std::min(kPressed, grasps.size()); ++i) {
    const PadPress pads(surface, stone.mass, scene.gripper, *grasps[i]);
    const Eigen::Vector3d n_T_down = -(T_W_O * grasps[i]->T_O_T).linear().row(2).transpose();
    best = std::max(best, pads.bear(n_T_down, kMaxWeights).share);
  }
  return best;
}

void hold_stone(const Stone& stone, const std::string& name, const PlanningScene& scene, GripperTally& tally,
                Results& results) {
  const std::string unfit = unfit_for_gripper(stone, scene.gripper);
  const std::vector<RestPose> poses = rest_poses(stone);
  int held = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    throw_if_interrupted();
    const Pose T_W_O = standing_at(stone, poses[k].R_W_O, {0.7, -0.18}, 0.0);
    const GraspFinder finder(scene, stone, -1, T_W_O, {});
    std::vector<const Grasp*> usable;
    for (const int i : finder.at_pick().usable)
      usable.push_back(&finder.set().grasps[static_cast<std::size_t>(i)]);
    held += usable.empty() ? 0 : 1;
    results.row({name, stone.name, k + 1, finder.set().grasps.size(), usable.size(),
                 usable.empty() ? 0.0 : firmest(stone, scene, usable, T_W_O),
                 usable.empty() && !unfit.empty() ? unfit : std::string()});
  }
  tally.poses += static_cast<int>(poses.size());
  tally.held += held;
  ++tally.stones;
  tally.stones_held += held > 0 ? 1 : 0;
}

void measure_grippers(const std::vector<std::string>& names, const std::vector<Stone>& stones,
                      Results& results) {
  std::vector<GripperTally> tallies;
  results.table("resting poses",
                {{"gripper"}, {"stone"}, {"pose"}, {"grasps"}, {"usable"}, {"bears_weights", 1}, {"unfit"}});
  for (const std::string& name : names) {
    PlanningScene scene;
    const hardware::CellLayout layout = hardware::with_gripper({}, name);
    scene.robot = read_robot("ur10");
    scene.gripper = read_gripper(name);
    scene.T_F_T = layout.T_F_T;
    scene.T_W_R = layout.T_W_R;
    GripperTally& tally = tallies.emplace_back();
    for (const Stone& stone : stones) hold_stone(stone, name, scene, tally, results);
  }
  results.table("grippers", {{"gripper"}, {"stones_held"}, {"stones"}, {"poses_held"}, {"poses"}});
  for (std::size_t i = 0; i < names.size(); ++i)
    results.row({names[i], tallies[i].stones_held, tallies[i].stones, tallies[i].held, tallies[i].poses});
}

}  // namespace

void add_grippers(CLI::App& app) {
  struct Command {
    CommonOptions common;
    std::vector<std::string> names{"robotiq-3f", "robotiq-2f-85", "robotiq-2f-140", "robotiq-hand-e"};
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("grippers", "What each gripper can hold of the stones as they lie");
  sub->add_option("--grippers", command->names, "Grippers, by name or YAML")
      ->delimiter(',')
      ->capture_default_str();
  command->common.register_draw(*sub);
  sub->footer("Example:\n  stonestack-bench grippers --grippers robotiq-2f-85,robotiq-hand-e");
  measure_by(*sub, [command](Results& results) {
    command->common.settings.apply({});
    results.settings({{"max_weights", kMaxWeights}});
    measure_grippers(command->names, command->common.read().stones, results);
  });
}

}  // namespace stonestack::bench

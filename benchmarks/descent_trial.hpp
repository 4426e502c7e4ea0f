#pragma once
#include <optional>
#include <string>
#include <vector>

#include "result_table.hpp"
#include "rooms.hpp"
#include "stacking/execute.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

/// Guarded descents of one stone, for `stonestack-bench descent`.
namespace stonestack::bench {

inline constexpr double kForceMark = 30.0;  ///< contact force that counts as hard, N

/// How descents ended.
struct DescentEnds {
  int descents = 0, missed = 0, early = 0, stopped = 0, hard = 0;
  int no_clearance =
      0;  ///< ended where the gripper would have met the support, before there was anything to feel
  std::vector<double> peaks;  ///< largest force of each descent, N
};
struct DescentTally {
  Results* results = nullptr;  ///< gets a note of each descent that went wrong; null: none
  std::uint64_t stone = 0;     ///< number of the stone that is carried
  int descents = 0, on_stone = 0;
  DescentEnds planned;        ///< as a plan has them
  DescentEnds gripper_first;  ///< at a place that no plan would choose
  DescentEnds shoved;  ///< earlier descents have moved it in the gripper; a program grasps anew for each
};

/// One cell with the stone that is carried (0) and the one it is set on (1).
class DescentTrial {
 public:
  /// `stones` must outlive this.
  DescentTrial(const std::vector<Stone>& stones, const SimulationOptions& simulation, Random random)
      : stones_(stones),
        random_(random),
        estimate_(Random::stream(static_cast<std::uint64_t>(simulation.seed), "believed pose")),
        simulated_(stones, {0_stone, 1_stone}, robot_, layout_, simulation),
        cell_(simulated_.cell()) {}
  /// False if no plan or no grasp comes about.
  bool pick();
  /// One descent; false when the stone has to be taken anew.
  bool descend(bool on_stone, DescentTally& tally);

 private:
  [[nodiscard]] Pose T_W_T();
  /// Of the tool, with this speed (m/s).
  [[nodiscard]] std::optional<JointTrajectory> straight(const Pose& T_W_T_goal, double speed);
  bool go(const Pose& T_W_T_goal, double speed);
  bool go_up();
  bool go_above(const Eigen::Vector2d& at, double stone_z);
  bool go_down(double by);
  /// The descent itself, from `far` (m) above the table.
  void measure(double far, DescentTally& tally);
  /// How far down (m, at most `max`) a program would go with the support as estimated by the camera.
  [[nodiscard]] double clearance(double max);
  /// Where the last descent ended, for --list.
  void print(const DescentTally& tally, const DescentEnds& ends, const std::string& end,
             const PoseDifference& before);
  /// The gripper and the support, without what the gripper holds.
  [[nodiscard]] PlanningScene gripper_and_support();
  /// True if fingers or palm come to the support before the stone does: a place that no plan would choose.
  [[nodiscard]] bool gripper_comes_first(const JointTrajectory& descent);
  /// The object that is nearest to the gripper, and its distance.
  [[nodiscard]] std::string nearest_to_gripper(const Joints& q);
  /// Of the stone, since the lift.
  [[nodiscard]] PoseDifference moved_in_gripper();
  /// Upward force at the wrist, N.
  [[nodiscard]] double level_force();
  /// True if the carried stone is on something, or nearer than kGap above the table.
  [[nodiscard]] bool touching();

  const std::vector<Stone>& stones_;
  Random random_, estimate_;
  RobotModel robot_ = read_robot("ur10");
  CellLayout layout_;
  MotionOptions options_;
  SimulatedCell simulated_;
  Cell cell_;
  GripperModel gripper_;               ///< with the fingers as they were spaced for the grasp
  Pose T_W_aside_ = Pose::Identity();  ///< of the support, in the field
  Pose T_T_O_ = Pose::Identity();      ///< after the lift
  int descent_ = 0;                    ///< number of the descent with this stone, from 1
  bool shoved_ = false;                ///< descents have moved it in the gripper further than a lift does
};

}  // namespace stonestack::bench

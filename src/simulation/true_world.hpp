#pragma once
#include <deque>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/rigid_world.hpp"
#include "simulation/finger_drive.hpp"
#include "simulation/gripper_body.hpp"
#include "simulation/true_table.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::simulation {

/// Load of the world on the gripper, gravity on the gripper itself left out; world axes.
struct GripperLoad {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< [N]
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< about the world's origin [Nm]
  void add(const Eigen::Vector3d& p_W, const Eigen::Vector3d& f) {
    force += f;
    moment += p_W.cross(f);
  }
  void add(const GripperLoad& other, double share = 1.0) {
    force += share * other.force;
    moment += share * other.moment;
  }
};

/// How far a stretch of time came.
struct Progress {
  double seconds = 0.0;
  std::string stopped;  ///< why the gripper cannot go on (it hit something); empty: it can
};

/// Load and motion of the gripper at a time, as the wrist sensor may report it later.
struct GripperMoment {
  double time = 0.0;  ///< [s]
  GripperLoad load;
  Pose T_W_T = Pose::Identity();
  Eigen::Vector3d a_W = Eigen::Vector3d::Zero();  ///< acceleration of its centre of mass [m/s^2]
};

/// Translation (m) and rotation vector (rad) of the tool by force (N) and moment (Nm) at its tip, axes of W.
using Compliance = Eigen::Matrix<double, 6, 6>;

/// Surroundings of the stones.
struct TrueScene {
  TrueTable table;
  int foreign = 0;  ///< the last so many stones of the list are objects that no catalogue has
};

/// True centre of mass of a gripper, m in T: beside the place where plans have it.
[[nodiscard]] Eigen::Vector3d gripper_centre(const GripperModel& gripper);

/// The one truth: stones of full resolution with their own mass, centre of mass and friction, the table, the
/// gripper that pushes and grips, in the engine of `options`. Only the simulated devices and the judge see
/// it.
///
/// Time passes in steps only while something can move; while all stones rest and the gripper is away from
/// them it just passes. Stones at rest that nothing comes near are held still meanwhile; a verdict never does
/// that.
class TrueWorld {
 public:
  /// The stones `present` (indices into `stones`), each far away until placed.
  TrueWorld(const std::vector<Stone>& stones, const std::vector<StoneIndex>& present,
            const GripperModel& gripper, const SimulationOptions& options, const TrueScene& scene = {});

  [[nodiscard]] const SimulationOptions& options() const { return options_; }
  /// Steps this world.
  [[nodiscard]] EngineKind engine_kind() const { return engine_kind_; }
  [[nodiscard]] const TrueTable& table() const { return scene_.table; }
  /// True for an object that no catalogue has.
  [[nodiscard]] bool is_foreign(StoneIndex stone) const;
  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] const GripperBody& gripper_body() const { return model_; }
  [[nodiscard]] const GripperPose& gripper_pose() const { return gripper_pose_; }
  /// Where a stiff arm would hold the gripper: paths begin here.
  [[nodiscard]] const GripperPose& commanded_pose() const { return commanded_; }
  /// From now on the arm gives way so much to what presses on the gripper.
  void set_compliance(const Compliance& compliance) { compliance_ = compliance; }
  /// Puts the gripper somewhere at once. For setting up.
  void set_gripper_pose(const GripperPose& gripper_pose);
  /// From now on these drives move the fingers, whatever a path asks of them.
  void drive_fingers(const std::array<FingerDriveState, kFingers>& drives) { drives_ = drives; }
  [[nodiscard]] const std::optional<std::array<FingerDriveState, kFingers>>& finger_drives() const {
    return drives_;
  }
  /// Lets `seconds` pass while the arm takes the gripper along `path`, from which the load pushes it. Ends
  /// early when the gripper hits something hard.
  Progress advance(double seconds, const GripperPath& path);
  /// Waits with the gripper where it is.
  Progress wait(double seconds);

  /// Mean over the last 10 ms, or the last `advance` if that was shorter.
  [[nodiscard]] const GripperLoad& load() const { return load_; }
  /// Load and motion `delay` ago, or the oldest that is kept (0.5 s); now with none.
  [[nodiscard]] GripperMoment moment_before(double delay) const;
  /// Force that presses each finger outwards, now: elastic force of its pad and contacts behind it, N.
  [[nodiscard]] const std::array<double, kFingers>& finger_force() const { return finger_force_; }

  [[nodiscard]] const std::vector<StoneIndex>& present() const { return present_; }
  [[nodiscard]] const ShapeList& shapes() const { return shapes_; }
  [[nodiscard]] const Pose& pose(StoneIndex stone) const { return state(stone).T_W_O; }
  [[nodiscard]] Eigen::Vector3d centre_of_mass(StoneIndex stone) const;
  /// True if the stone has not moved for two seconds.
  [[nodiscard]] bool rests(StoneIndex stone) const;
  /// Puts a stone somewhere at once, at rest. For setting up.
  void place(StoneIndex stone, const Pose& T_W_O);
  /// Takes a stone out of play, far from where any other may come; `place` brings it back. For setting up.
  void put_away(StoneIndex stone);
  /// Contacts as they are now, after one step of a world of its own. Bodies are numbered as stones are.
  [[nodiscard]] std::vector<Contact> contacts() const;
  /// State of stones and gripper as JSON, to be restored in another process, at rest. Not in it: what a late
  /// force sensor would still report.
  [[nodiscard]] nlohmann::json kept() const;
  void restore(const nlohmann::json& kept);
  /// A world with every stone free and the true frictions, without the gripper. Body i is `present()[i]`.
  [[nodiscard]] std::unique_ptr<RigidWorld> judge_world(double step, int iterations,
                                                        EngineKind engine = EngineKind::kBullet) const;

 private:
  static constexpr int kIterations = 50;  // of the contact solver
  struct StoneState {
    Pose T_W_O = Pose::Identity();
    Twist twist;
    Pose T_W_O_rest = Pose::Identity();  // where it has been since ...
    double rest = 0.0;                   // ... this many seconds
    bool aside = true;
    std::vector<PadContact> pads;
  };
  /// The world that is stepped while some stones are in play.
  struct Engine {
    std::unique_ptr<RigidWorld> world;
    double step = 0.0;          // s
    std::vector<bool> in_play;  // by index into present
    int first_box = 0;          // body of the gripper's first box
  };

  [[nodiscard]] const StoneState& state(StoneIndex stone) const;
  [[nodiscard]] StoneState& state(StoneIndex stone);
  [[nodiscard]] std::vector<bool> stones_in_play(const GripperPose& next) const;
  [[nodiscard]] double step_of_pads();
  [[nodiscard]] std::unique_ptr<RigidWorld> make_world(EngineKind engine, double step, int iterations,
                                                       double damping,
                                                       const std::vector<bool>& in_play) const;
  void prepare_engine(const std::vector<bool>& in_play, double step);
  void step_engine(const GripperPose& wanted);
  [[nodiscard]] GripperPose yielded(GripperPose wanted) const;
  void yield_to(const GripperLoad& load, double seconds);
  void remember(double seconds);
  void drop_what_fell();
  [[nodiscard]] GripperPose driven(GripperPose next, double seconds);
  void press_pads(const GripperPose& next, double step);
  void read_stones(double step);
  [[nodiscard]] GripperLoad read_contacts(double step);
  /// Corner of the gripper that is nearest to the table, or deepest in it, m in W.
  [[nodiscard]] Eigen::Vector3d corner_at_table() const;
  [[nodiscard]] GripperLoad table_load() const;
  [[nodiscard]] std::string hard_contact() const;
  /// ", hardest by PART at PLACE" of what presses on rigid parts of the gripper; empty without any.
  [[nodiscard]] std::string hardest_contact() const;

  SimulationOptions options_;
  EngineKind engine_kind_;
  TrueScene scene_;
  GripperBody model_;
  std::vector<StoneIndex> present_;
  ShapeList shapes_;                // by catalogue index, true masses
  std::vector<StoneState> states_;  // by catalogue index
  std::vector<double> friction_;    // by pair of catalogue indices, row by row; last column: the table
  GripperPose gripper_pose_;
  GripperPose commanded_;
  Compliance compliance_ = Compliance::Zero();
  Eigen::Matrix<double, 6, 1> yield_ =
      Eigen::Matrix<double, 6, 1>::Zero();  // from the commanded tool, m, rad
  std::deque<GripperMoment> moments_;
  Eigen::Vector3d v_W_ = Eigen::Vector3d::Zero();  // of the gripper's centre [m/s]
  std::optional<std::array<FingerDriveState, kFingers>> drives_;
  GripperLoad load_;
  Eigen::Vector3d felt_ = Eigen::Vector3d::Zero();  // N, load_ over 10 ms: a knock is no jam
  GripperLoad pad_load_;
  std::array<double, kFingers> finger_force_{};
  double time_ = 0.0;
  double debt_ = 0.0;             // s asked for and not yet stepped
  std::optional<Engine> engine_;  // empty while nothing can move
};

}  // namespace stonestack::simulation

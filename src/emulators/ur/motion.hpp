#pragma once
#include <string>
#include <vector>

#include "emulators/ur/arm_geometry.hpp"
#include "emulators/ur/profile.hpp"

namespace stonestack::emulators {

/// How fast and how: the arguments of movej and movel.
struct MoveOptions {
  double acceleration = 1.4;
  double speed = 1.05;
  double seconds = 0.0;  ///< > 0: overrides the other two
  double blend = 0.0;    ///< [m]
};

/// Request of force_mode.
struct ForceMode {
  bool active = false;
  Pose T_B_task = Pose::Identity();
  Six selection = Six::Zero();
  Six wrench = Six::Zero();  ///< wrench that the tool presses with, task frame [N, Nm]
  Six limits = Six::Zero();  ///< speed limits on the compliant axes [m/s, rad/s]
};

/// Makes joint targets, a control step at a time, as the controller's motion functions ask. One command is
/// current; `done` says when its function returns. What still moves then (a blend, a speed) goes on until
/// the next command.
///
/// Assumptions, where UR documents nothing: `t` of a move spends half of it at full speed; blends superpose
/// the end of one move and the start of the next; servoj follows as a critically damped filter that lags by
/// lookahead_time + 4/gain; force_mode moves at 2 mm/s per N of difference.
class Motion {
 public:
  Motion(const RobotModel& robot, const Joints& q);

  [[nodiscard]] const ArmGeometry& geometry() const { return geometry_; }

  void move_joints(const Joints& q, const MoveOptions& options);
  void move_line(const Pose& T_B_P, const MoveOptions& options);
  /// Along the circle through where the tool is, `via` and T_B_P. Straight when they lie on a line.
  void move_arc(const Pose& via, const Pose& T_B_P, const MoveOptions& options);
  void servo(const Joints& q, double seconds, double lookahead, double gain);
  /// `seconds` < 0: until the speed is reached.
  void speed_joints(const Joints& qd, double acceleration, double seconds);
  void speed_line(const Six& twist, double acceleration, double seconds);
  void stop_joints(double acceleration);
  void stop_line(double acceleration);
  /// Stops hard where it is and forgets every command.
  void freeze();
  void set_force_mode(const ForceMode& mode);
  /// Another tool centre point, in the flange's frame. The arm stays where it is; what goes on moves the new
  /// point as it would have moved the old one.
  void set_tool(const Pose& T_F_P);

  /// The current command's function may return.
  [[nodiscard]] bool done() const;
  [[nodiscard]] bool moving() const;
  [[nodiscard]] bool in_force_mode() const { return force_.active; }
  /// Where the tool is at the end of the newest move; without one, where it shall be now.
  [[nodiscard]] Pose T_B_waypoint() const;
  /// Moves in progress: two or three of a path with blends, however long it is.
  [[nodiscard]] std::size_t moves_in_progress() const { return moves_.size(); }

  /// Goes on by `seconds` of the motion's own time, which speed scaling stretches. `wrench_B` is what presses
  /// on the tool at P, base axes. Returns why that cannot be, leaving target and command as they were; else
  /// empty.
  [[nodiscard]] std::string step(double seconds, const Six& wrench_B);

  [[nodiscard]] const Joints& q() const { return q_; }
  [[nodiscard]] const Joints& qd() const { return qd_; }
  [[nodiscard]] const Joints& qdd() const { return qdd_; }

 private:
  enum class Mode { kRest, kMoves, kServo, kSpeed };
  struct Move {
    Six displacement = Six::Zero();
    Profile profile;
    double t = 0.0;
    double blend = 0.0;                                   // in the profile's length
    Eigen::Vector3d n_B_arc = Eigen::Vector3d::Zero();    // times the angle; zero: a straight path
    Eigen::Vector3d p_B_spoke = Eigen::Vector3d::Zero();  // from the centre to the start
    [[nodiscard]] Six displacement_at(double share) const;
  };

  void begin_moves(bool line, double acceleration);
  void push(const Six& displacement, double length, const MoveOptions& options, double blend);
  [[nodiscard]] Six corner() const;
  void begin_speed(bool line, const Six& target, double acceleration, double seconds);
  [[nodiscard]] bool next_moves(double seconds, Joints& q);
  void leave_finished_moves();
  [[nodiscard]] bool next_servo(double seconds, Joints& q);
  [[nodiscard]] bool next_speed(double seconds, Joints& q);
  [[nodiscard]] bool press(double seconds, const Six& wrench_B, Joints& q);
  [[nodiscard]] std::string judge(const Joints& q, double seconds) const;
  [[nodiscard]] Pose compose(const Pose& start, const Six& displacement) const;

  ArmGeometry geometry_;
  Mode mode_ = Mode::kRest;
  bool line_ = false;  // moves and speeds: in the tool's space
  Joints q_, qd_ = Joints::Zero(), qdd_ = Joints::Zero();
  std::vector<Move> moves_;
  Joints q_start_;  // of the moves
  Pose T_B_start_ = Pose::Identity();
  double elapsed_ = 0.0, hold_ = 0.0;  // s, of a servo or speed command
  Joints servo_target_ = Joints::Zero();
  double servo_lag_ = 0.1;
  Six speed_ = Six::Zero(), speed_target_ = Six::Zero();
  Pose T_B_speed_ = Pose::Identity();
  double speed_acceleration_ = 1.0;
  ForceMode force_;
  Joints q_unpressed_;  // what the motion alone asks for, while force mode shifts the tool
  Six shift_ = Six::Zero();
};

}  // namespace stonestack::emulators

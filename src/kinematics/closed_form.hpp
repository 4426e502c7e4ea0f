#pragma once
#include <array>

#include "kinematics/inverse.hpp"

/// Private to kinematics: the parts of the closed form, in DH angles.
namespace stonestack::kinematics {

inline constexpr double kClamp = 5e-10;  ///< how far outside the reach a pose may lie and still be met [m]
/// Distance [m] that a solution may be off before it is polished: where the wrist is over the base, rounding
/// leaves 1e-8 rad of the base's angle, and with wrist 2 in line to within that no more is left of wrist 3
/// than a guess.
inline constexpr double kGuess = 1e-6;

/// Pose of the last DH frame, and the wrist's centre, in the DH base.
struct Target {
  Eigen::Vector3d x, y, z;
  Eigen::Vector3d p_wrist;  ///< origin of DH frame 5
};
[[nodiscard]] Target target_of(const RobotModel& robot, const Pose& T_R_F);

/// An angle with its cosine and sine, so that neither is worked out twice.
struct Turn {
  double angle = 0;
  double c = 1, s = 0;
};
[[nodiscard]] Turn turn_by(double angle);

/// The two angles of the base that bring the wrist into the arm's plane.
struct Shoulder {
  std::array<Turn, 2> q1;
  double miss = 0;  ///< by which the target was out of reach [m]: the two are then one
};
/// `apart` rad: the two are kept at least so far from being one.
[[nodiscard]] Shoulder solve_shoulder(const RobotModel& robot, const Target& t, double apart = 0.0);

/// Wrist angles and the arm's plane for one shoulder angle.
struct Wrist {
  Turn q1, q5;
  double q6 = 0;
  double sine = 0;      ///< |sin q5|
  double q234 = 0;      ///< direction of the gripper in the arm's plane
  double u = 0, v = 0;  ///< wrist 1 in the arm's plane, from the shoulder
};
[[nodiscard]] Wrist solve_wrist(const RobotModel& robot, const Target& t, const Turn& q1, bool flipped,
                                double q6_when_free);
/// The arm's plane when the flange is turned by `q6` on wrist 3.
void set_tool(const RobotModel& robot, const Target& t, const Turn& q6, Wrist& wrist);
/// With wrist 2 in line, wrist 3 is free or nearly so, and its value (the seed's, or what rounding left of
/// it) may put wrist 1 out of reach although another one does not. Turns it to the nearest that reaches, if
/// that moves the flange by less than kGuess.
void turn_into_reach(const RobotModel& robot, const Target& t, Wrist& wrist);

/// Elbow angle in [0, pi], and by how much (m) the target was out of its reach.
struct Elbow {
  Turn q3;
  double miss = 0;
};
[[nodiscard]] Elbow solve_elbow(const RobotModel& robot, const Wrist& wrist);

/// Upper arm and forearm with the elbow up: `rise` to wrist 1, the upper arm `bend` below that (elbow down:
/// above), `elbow` between the two.
struct ArmBend {
  double rise = 0, bend = 0, elbow = 0;
};
[[nodiscard]] ArmBend bend_of(const RobotModel& robot, const Wrist& wrist, const Turn& q3);
/// The angles of a branch (whose bit 4 is the elbow's), each nearest to the seed.
[[nodiscard]] IkSolution solution(const RobotModel& robot, const Wrist& wrist, const ArmBend& bend,
                                  int branch, const Joints& seed);
/// The equivalent of `angle` nearest to `seed`.
[[nodiscard]] double nearest_turn(double angle, double seed);

}  // namespace stonestack::kinematics

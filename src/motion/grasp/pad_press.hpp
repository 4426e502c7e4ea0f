#pragma once
#include <array>
#include <vector>

#include "motion/grasp.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::motion {

/// The planner's model of a gripper closed on a stone: each pad is an elastic foundation
/// with friction, the stone its scan, the fingers stay where their force was reached. What three contact
/// points with mean normals cannot predict, it can: how large a touched patch is, how it shrinks while the
/// stone turns in the gripper, and how far the stone sags from where it was grasped. Elastic constants:
/// GripperModel.
class PadPress {
 public:
  /// `surface`: samples of the stone's scan, about 3 mm apart. `mass`: of the stone.
  PadPress(const std::vector<SurfaceSample>& surface, const MassProperties& mass, const GripperModel& gripper,
           const Grasp& grasp);

  /// How a load is borne.
  struct Load {
    double share = 0.0;   ///< of the weight, largest that the pads were found to bear
    double moved = 0.0;   ///< centre of mass in the gripper under the weight itself [m]
    double turned = 0.0;  ///< the same [rad]
  };
  /// With gravity along the unit vector `n_T_down`; loads up to `max` times the weight are tried.
  [[nodiscard]] Load bear(const Eigen::Vector3d& n_T_down, double max) const;
  /// False: the stone slips out while the gripper closes; no load is borne.
  [[nodiscard]] bool holds() const { return holds_; }
  /// Amount by which closing the gripper turns the stone [rad].
  [[nodiscard]] double squeeze_turn() const { return gripped_.u.tail<3>().norm(); }
  /// Depth by which the stone presses into the pad of finger A, B or C [m].
  [[nodiscard]] double deepest(int finger) const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  struct Sample {
    Eigen::Vector3d p, r;  // in T; from the centre of mass
    double area = 0.0;     // m^2, across the pad's normal
    int pad = 0;
  };
  struct State {
    Vector6 u = Vector6::Zero();    // of the stone: shift and small turn about its centre of mass
    std::array<double, 3> place{};  // m, of each pad from the plane x = 0
  };
  /// Contact of a closing pad.
  struct Met {
    double height = 0.0;  // m, of the surface towards its finger
    double stiff = 0.0;   // N/m
  };
  void squeeze();
  void close(State& state, int pad);
  [[nodiscard]] double height(const State& state, const Sample& sample) const;
  /// On the stone; of the stiffness the lower triangle.
  Vector6 forces(const State& state, Matrix6* stiffness) const;
  bool settle(State& state, const Vector6& load) const;

  const GripperModel& gripper_;
  double weight_ = 0.0;
  std::vector<Sample> samples_;
  std::vector<Met> met_;            // of one pad at a time; kept for its memory
  int pads_ = 3;                    // of A, B and C, or of A and B
  std::array<double, 3> wanted_{};  // N, of each finger
  State gripped_;
  bool holds_ = false;
};

}  // namespace stonestack::motion

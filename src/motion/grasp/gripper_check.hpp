#pragma once
#include <vector>

#include "motion/collision/convex_core.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// The gripper alone, as it comes straight along its own z to a grasp (or leaves it), against table and
/// objects. Cheaper than the whole arm, and asked for hundreds of grasps. Built once for a scene.
class GripperCheck {
 public:
  /// `approach` m: length of the straight approach; `left_out`: index of an object that does not count, or
  /// -1.
  GripperCheck(const PlanningScene& scene, double approach, int left_out);

  /// Object nearer to the gripper than `padding`.
  struct Hit {
    enum class What { kNothing, kTheTable, kObject };
    What what = What::kNothing;
    int object = -1;
  };
  /// Fingers of an open gripper.
  struct Fingers {
    double opening = 0.0;  ///< between the pads [m]
    double advance = 0.0;  ///< z of the tips in T [m]: the largest until they are closed
  };
  /// First hit anywhere on the approach that ends at T_W_T.
  [[nodiscard]] Hit sweep(const Pose& T_W_T, const Fingers& fingers, double padding) const;
  /// Checks objects alone: true if it comes nearer than that to one, whatever the table.
  [[nodiscard]] bool touches_object(const Pose& T_W_T, const Fingers& fingers, double padding) const;

 private:
  static constexpr double kNoPadding = -1.0;  ///< the user asks for none of his own [m]
  struct Part {
    ConvexCore core;  ///< swept, in T, fingers closed
    double finger_side = 0.0;
    double advance = 0.0;
  };
  struct Piece {
    ConvexCore core;  ///< in W
    Eigen::Vector3d centre;
    double radius = 0.0;
    int object = -1;
    double user_padding = kNoPadding;
  };
  /// Its index, or -1.
  [[nodiscard]] int first_object(const Pose& T_W_T, const Fingers& fingers, double padding) const;
  [[nodiscard]] bool near(const Part& part, const Pose& T_W_part, const Piece& piece, double padding) const;

  std::vector<Part> parts_;
  std::vector<Piece> pieces_;
  double table_z_ = 0.0;
  double table_padding_ = kNoPadding;
};

}  // namespace stonestack::motion

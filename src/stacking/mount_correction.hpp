#pragma once
#include "kinematics/camera_mount.hpp"
#include "stonestack/hardware/cell.hpp"

/// Private to stacking/: a camera mount and a table that views agree on, and whether it may be applied.
namespace stonestack::stacking {

/// Correction of a layout by views.
struct MountCorrection {
  Pose T_T_C = Pose::Identity();    ///< the mount that the views agree on
  Pose T_level = Pose::Identity();  ///< moves W so that the table that was seen lies in z = 0
  double height = 0.0;              ///< of that table in the middle of the field before [m]
  double tilt = 0.0;                ///< likewise [rad]
  /// False where mount or table lie further off than a calibration errs, or the views still disagree: then it
  /// was calibrated wrongly or has been hit, and a person should know.
  bool accepted = false;
};
/// Moves W so that a table, which was found to lie beside the plane z = 0, lies in it; about a point of the
/// table, `middle` (m in W).
[[nodiscard]] Pose levelled(const Plane& table_W, const Eigen::Vector2d& middle);
/// Judges what the views agree on for a layout.
[[nodiscard]] MountCorrection correction_of(const MountRefinement& found, const CellLayout& layout);
/// Corrects the layout: the mount, and the robot against W, not the table, so that z = 0 is the table for all
/// that plans.
void apply(const MountCorrection& correction, CellLayout& layout);

}  // namespace stonestack::stacking

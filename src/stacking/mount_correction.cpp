#include "stacking/mount_correction.hpp"

#include <cmath>

namespace stonestack::stacking {
namespace {

// A mount further off than this was calibrated wrongly or has been hit; a person should know.
constexpr double kMaxShift = 0.008;                              // m
constexpr double kMaxTurn = 0.026;                               // rad
constexpr double kMaxLeft = 0.002;                               // m between the views afterwards
constexpr double kMaxTableHeight = 0.012, kMaxTableTilt = 0.03;  // m, rad: likewise of the table

}  // namespace

Pose levelled(const Plane& table_W, const Eigen::Vector2d& middle) {
  const double height = (table_W.offset - table_W.normal.head<2>().dot(middle)) / table_W.normal.z();
  const Eigen::Vector3d p_W(middle.x(), middle.y(), height);
  const auto turn = Eigen::Quaterniond::FromTwoVectors(table_W.normal, Eigen::Vector3d::UnitZ());
  return Eigen::Translation3d(middle.x(), middle.y(), 0.0) * turn * Eigen::Translation3d(-p_W);
}

MountCorrection correction_of(const MountRefinement& found, const CellLayout& layout) {
  const Eigen::Vector2d& middle = layout.field_centre;
  MountCorrection correction;
  correction.T_T_C = found.T_T_C;
  correction.T_level = levelled(found.table_W, middle);
  correction.height = -(correction.T_level * Eigen::Vector3d(middle.x(), middle.y(), 0.0)).z();
  correction.tilt = Eigen::AngleAxisd(correction.T_level.rotation()).angle();
  correction.accepted = found.shift <= kMaxShift && found.turn <= kMaxTurn && found.after <= kMaxLeft &&
                        std::abs(correction.height) <= kMaxTableHeight && correction.tilt <= kMaxTableTilt;
  return correction;
}

void apply(const MountCorrection& correction, CellLayout& layout) {
  layout.T_T_C = correction.T_T_C;
  layout.T_W_R = correction.T_level * layout.T_W_R;
}

}  // namespace stonestack::stacking

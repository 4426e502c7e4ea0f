#pragma once
#include <optional>

#include "detection/scene/preprocess.hpp"

namespace stonestack::detection {

/// Prior of the error of a view's pose: half a squared sum x'Hx / 2 + g'x over a
/// small motion x of the view (translation m, rotation rad, in V), around where it is taken to be now.
struct ViewConstraint {
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
};

/// The arm's report (errs by `view_shift` and `view_turn` an axis) and the table: what the view takes for it
/// must be the table of the first view, `table_C`.
[[nodiscard]] ViewConstraint view_constraint(const std::optional<Plane>& table_C, const SeenView& view,
                                             const Pose& T_C_V);

/// T_C_V that agrees best with the arm's report and the table, for a view that was reported at view.T_C_V.
[[nodiscard]] Pose aligned_view(const std::optional<Plane>& table_C, const SeenView& view);

/// The table, if the first view shows it: what further views can be held to.
[[nodiscard]] std::optional<Plane> seen_table(const DetectionScene& scene);

}  // namespace stonestack::detection

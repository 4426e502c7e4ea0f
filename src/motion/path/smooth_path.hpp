#pragma once
#include <vector>

#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {

/// A line, or a part of a curve that cuts a corner, over path length s in [0, length] (joint vector, rad).
/// Pieces join with continuous direction; with Corner::kEven with continuous curvature, too.
struct PathPiece {
  Joints start;
  Joints tangent;    ///< dq/ds at s = 0
  Joints curvature;  ///< d2q/ds2 at s = 0; zero for a line
  double length = 0.0;
  bool stop_after = false;        ///< a corner that is not cut: rest there
  Joints third = Joints::Zero();  ///< d3q/ds3, constant; zero for a line and for a parabola

  [[nodiscard]] bool is_line() const { return curvature.isZero(0.0) && third.isZero(0.0); }
  [[nodiscard]] Joints at(double s) const {
    return start + s * (tangent + s * (curvature / 2.0 + s * third / 6.0));
  }
  [[nodiscard]] Joints tangent_at(double s) const { return tangent + s * (curvature + 0.5 * s * third); }
  [[nodiscard]] Joints curvature_at(double s) const { return curvature + s * third; }
};

/// How a corner is cut: by a parabola, on which acceleration may be constant, or by two cubics whose
/// curvature rises evenly from zero and falls back, on which jerk is bounded at constant speed.
enum class Corner { kParabola, kEven };

/// The path with corners cut by at most `blend`; lines longer than `longest_line` are split. Empty when the
/// path has no length.
[[nodiscard]] std::vector<PathPiece> smooth_pieces(const JointPath& path, double blend, double longest_line,
                                                   Corner corner = Corner::kParabola);

}  // namespace stonestack::motion

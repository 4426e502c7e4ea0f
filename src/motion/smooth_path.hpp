#pragma once
#include <vector>

#include "stonestack/kinematics/joints.hpp"

namespace stonestack {

/// A line, or a parabola that cuts a corner, over path length s in [0, length] (joint vector, rad). Unit
/// tangent at both ends, so pieces join with continuous direction.
struct PathPiece {
  Joints start;
  Joints tangent;    ///< dq/ds at s = 0
  Joints curvature;  ///< d2q/ds2, constant; zero for a line
  double length = 0.0;
  bool stop_after = false;  ///< a corner that is not cut: rest there

  [[nodiscard]] bool is_line() const { return curvature.isZero(0.0); }
  [[nodiscard]] Joints at(double s) const { return start + s * tangent + 0.5 * s * s * curvature; }
  [[nodiscard]] Joints tangent_at(double s) const { return tangent + s * curvature; }
};

/// The path with corners cut by at most `blend`; lines longer than `longest_line` are split. Empty when the
/// path has no length.
[[nodiscard]] std::vector<PathPiece> smooth_pieces(const JointPath& path, double blend, double longest_line);

}  // namespace stonestack

#pragma once
#include <Eigen/Core>
#include <vector>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::physics {

/// The table's index where a body index is asked for.
inline constexpr int kTable = -1;

/// A point where two bodies touch.
struct Contact {
  int below = kTable;  ///< body index or kTable
  int above = 0;       ///< body index; `normal` points from `below` to `above`
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
  double gap = 0.0;      ///< negative [m]: penetration
  double impulse = 0.0;  ///< N s, normal, of the last step
};

}  // namespace stonestack::physics

#pragma GCC visibility pop

#pragma once
#include <CLI/CLI.hpp>
#include <numbers>

#include "rooms.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::bench {

/// Error of a stone's estimated pose, as after a view of the camera: one sigma
/// along and about each axis.
struct ViewError {
  double shift = 0.0007;                       ///< along each axis, m
  double turn = 0.5 * std::numbers::pi / 180;  ///< about each axis, rad

  void add_options(CLI::App& bench);
  /// Where a stone at T_W_O is thought to be.
  [[nodiscard]] Pose estimated(const Pose& T_W_O, Random& random) const;
};

}  // namespace stonestack::bench

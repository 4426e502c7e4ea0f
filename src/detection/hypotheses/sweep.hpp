#pragma once
#include <span>
#include <vector>

#include "detection/features/consistency.hpp"

namespace stonestack::detection {

/// How finely orientations are tried.
struct SweepOptions {
  int turns = 24;        ///< about the line of sight
  int points = 48;       ///< of the cluster that each trial evaluates
  int best = 16;         ///< hypotheses at most
  double apart = 0.3;    ///< between any two hypotheses [rad]
  double reach = 0.015;  ///< distances count up to this [m]
  double area_low =
      0.35;  ///< of the side's shadow that the cluster covers at least (it may be hidden in part)
  double area_high = 1.4;  ///< and at most
  int shifts = 0;          ///< steps by which each trial may slide to where it fits, ...
  double glance = 1.0;     ///< share of the orientations that remain after a first trial of each from the
                           ///< aligned centres alone, on a third of the points
  double aside = 0.0;  ///< ... from the aligned centres and from this far to four sides of them [m]: where
                       ///< other stones hide a part, centres do not agree
};

/// Tries every orientation of the model on one cluster that one view saw from `eye`, with the visible centres
/// aligned: needs neither normals nor descriptors to be good, only that the cluster is one stone, more or
/// less.
[[nodiscard]] std::vector<Hypothesis> sweep_orientations(const DetectionModel& model,
                                                         const SurfacePoints& seen,
                                                         std::span<const int> cluster,
                                                         const Eigen::Vector3f& eye,
                                                         const SweepOptions& options);

/// Unit vectors spread evenly over the sphere (Fibonacci lattice).
[[nodiscard]] std::vector<Eigen::Vector3f> even_directions(int count);

}  // namespace stonestack::detection

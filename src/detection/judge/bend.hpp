#pragma once
#include <Eigen/Core>

namespace stonestack::detection {

/// Tally of how the seen surface bends where the model's does. A flat strip lies within the tolerance of a
/// round model and roughly along its normals, but its own normals do not turn with the model's.
class BendTally {
 public:
  /// Adds a place that fits: the unit normals of model and seen surface there, in the frame of one view.
  void add(const Eigen::Vector3d& model, const Eigen::Vector3d& seen, double weight);
  /// Ends the view: what is added next is in the frame of another.
  void end_view();
  /// Mean square of how far the model's normals are from their mean, 0 (flat) to 1, over all ended views.
  [[nodiscard]] double variation() const;
  /// Share of the model's bend that the seen surface has, by regression of its normals on the model's: 1
  /// where both bend alike, 0 where the seen one is flat; 1 without a bend.
  [[nodiscard]] double agreement() const;

 private:
  double weight_ = 0.0, products_ = 0.0, squares_ = 0.0;  // of the view
  Eigen::Vector3d model_ = Eigen::Vector3d::Zero(), seen_ = Eigen::Vector3d::Zero();
  double all_weight_ = 0.0, covariance_ = 0.0, variance_ = 0.0;  // of the views before
};

}  // namespace stonestack::detection

#pragma once
#include <vector>

#include "detection/features/models.hpp"

namespace stonestack::detection {

/// Linear least squares around the present estimate: H x = -g.
struct LinearSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  int points = 0;
};

/// A point that may show a stone.
struct StoneSample {
  Eigen::Vector3f p_V, normal_V;  ///< in its view
  int patch = 0;                  ///< of the view's smooth error
  float pixels = 1.0F;            ///< that the point is the mean of
  int face = -1;                  ///< that was nearest last
};

/// Evidence of one view about one stone, and the smooth error of that view around it.
class StoneInView {
 public:
  StoneInView(const SeenView& view, std::vector<StoneSample> samples);

  /// Normal equations for (motion of the seen points about the stone's centre, in O; motion of the view, in
  /// V), 12 unknowns, with the smooth error eliminated: it has its prior and the table beside the stone.
  [[nodiscard]] LinearSystem normal_equations(const DetectionModel& model, const Pose& T_O_V);
  /// After a step: the smooth error that goes with it.
  void update_error(const Eigen::VectorXd& step);

 private:
  void lay_patches(const SeenView& view);

  std::vector<StoneSample> samples_;
  Eigen::MatrixXd prior_;           ///< covariance of the patches' error
  Eigen::VectorXd table_, weight_;  ///< what the table shows of it, and how surely (1 / m^2)
  Eigen::VectorXd error_;           ///< the present estimate [m]
  Eigen::MatrixXd cross_, gain_;    ///< of the last equations
  Eigen::VectorXd gradient_;
  double noise_ = 0.0;  ///< of a pixel [m^2]
};

}  // namespace stonestack::detection

#pragma once
#include <array>
#include <map>
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

/// How the model's own error at one place of its surface moves the gradient of a view's equations.
struct ModelScore {
  Eigen::Matrix<double, 12, 1> sum = Eigen::Matrix<double, 12, 1>::Zero();  ///< of the points there, weighted
  double variance = 0.0;  ///< of the error, summed over the points [m^2]
  double points = 0.0;
};
using ModelScores = std::map<std::array<int, 3>, ModelScore>;  ///< by place

/// Evidence of one view about one stone, and the smooth error of that view around it.
class StoneInView {
 public:
  StoneInView(const SeenView& view, std::vector<StoneSample> samples);

  /// Normal equations for (motion of the seen points about the stone's centre, in O; motion of the view, in
  /// V), 12 unknowns, with the smooth error eliminated: it has its prior and the table beside the stone.
  [[nodiscard]] LinearSystem normal_equations(const DetectionModel& model, const Pose& T_O_V);
  /// Scores of the model's error in the last equations. It is the same error in every view: views that show
  /// one place do not average it out.
  [[nodiscard]] ModelScores model_scores() const;
  /// After a step: the smooth error that goes with it.
  void update_error(const Eigen::VectorXd& step);

 private:
  /// A sample as the last equations took it.
  struct Weighed {
    Eigen::Matrix<double, 12, 1> weighted_J;
    double weighted_slope, model_variance;
    std::array<int, 3> place;  ///< on the model
    int patch;
  };

  void lay_patches(const SeenView& view);

  std::vector<StoneSample> samples_;
  Eigen::MatrixXd prior_;           ///< covariance of the patches' error
  Eigen::VectorXd table_, weight_;  ///< what the table shows of it, and how surely (1 / m^2)
  Eigen::VectorXd error_;           ///< the present estimate [m]
  Eigen::MatrixXd cross_, gain_;    ///< of the last equations
  Eigen::VectorXd gradient_;
  std::vector<Weighed> weighed_;
  double noise_ = 0.0;  ///< of a pixel [m^2]
};

}  // namespace stonestack::detection

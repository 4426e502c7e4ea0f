#include "view_error.hpp"

namespace stonestack::bench {

void ViewError::add_options(CLI::App& bench) {
  bench.add_option("--shift", shift, "Position error, one sigma along each axis [m]")
      ->check(CLI::Range(0.0, 0.02))
      ->capture_default_str();
  bench.add_option("--turn", turn, "Attitude error, one sigma about each axis [rad]")
      ->check(CLI::Range(0.0, 0.2))
      ->capture_default_str();
}

Pose ViewError::estimated(const Pose& T_W_O, Random& random) const {
  const auto triple = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
  Pose T = T_W_O;
  T.pretranslate(shift * triple());
  const Eigen::Vector3d w = turn * triple();
  if (w.norm() > 1e-12)
    T.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix() * T.linear();
  return T;
}

}  // namespace stonestack::bench

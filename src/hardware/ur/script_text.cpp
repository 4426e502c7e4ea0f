#include "hardware/ur/script_text.hpp"

#include <cmath>
#include <cstdio>

#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kMax = 1e9;

template <class Vector>
std::string join_numbers(const Vector& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i > 0 ? ", " : "") + to_script(values[i]);
  return text + "]";
}

}  // namespace

std::string to_script(double value) {
  require(std::isfinite(value) && std::abs(value) < kMax, "a script takes finite numbers below ", kMax,
          ", not ", value);
  char text[32];
  std::snprintf(text, sizeof text, "%.9f", value == 0.0 ? 0.0 : value);
  return text;
}

std::string to_script(const Eigen::Vector3d& values) {
  return join_numbers(values);
}

std::string to_script(const Joints& values) {
  return join_numbers(values);
}

std::string to_script(const Pose& pose) {
  const Eigen::AngleAxisd turn(pose.rotation());
  Joints values;
  values << pose.translation(), turn.angle() * turn.axis();
  return concat("p", join_numbers(values));
}

}  // namespace stonestack::hardware

#include "simulation/finger_linkage.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::simulation {
namespace {

// Joint 2 lies at (0.050, -0.028) m in the frame of joint 1, joint 3 another 0.039 m on at -0.52 rad: in line
// with it to a millimetre. The link from joint 1 to joint 3 leans outwards by kSetBack where theta_1 is 0.
const double kSetBack = std::atan2(0.028 + 0.039 * std::sin(0.52), 0.050 + 0.039 * std::cos(0.52));
constexpr double kMinTheta = 0.0495, kMaxTheta = 1.2218;  // rad

}  // namespace

FingerLinkage finger_linkage(double place) {
  FingerLinkage finger;
  const double sine = (kFirstJointAside - kPadInside - place) / kLinkLength;
  finger.theta_1 = std::clamp(kSetBack + std::asin(std::clamp(sine, -1.0, 1.0)), kMinTheta, kMaxTheta);
  finger.lean = finger.theta_1 - kSetBack;
  finger.knuckle = kFirstJointAside - kLinkLength * std::sin(finger.lean);
  finger.knuckle_top = kFirstJointTop + kLinkLength * std::cos(finger.lean);
  finger.tip = finger.knuckle_top + kLastPhalanx;
  return finger;
}

}  // namespace stonestack::simulation

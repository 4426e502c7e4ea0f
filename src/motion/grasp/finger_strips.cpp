#include "motion/grasp/finger_strips.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::motion {

double palm_front(const GripperModel& gripper) {
  double front = -1e300;
  for (const GripperBox& box : gripper.boxes)
    if (box.finger_side == 0.0 && !box.camera) front = std::max(front, box.p_T_centre.z() + box.size.z() / 2);
  return front;
}

GripperView view_from(std::span<const SurfaceSample> surface, const Eigen::Vector3d& p_O_M,
                      const Eigen::Matrix3d& R_O_T) {
  GripperView view{R_O_T, std::vector<Eigen::Vector3d>(surface.size()), 0.0};
  const Eigen::Matrix3d R_T_O = R_O_T.transpose();
  for (std::size_t i = 0; i < view.p_T.size(); ++i) {
    view.p_T[i] = R_T_O * (surface[i].point - p_O_M);
    view.back = std::min(view.back, view.p_T[i].z());
  }
  return view;
}

int FingerStrip::slice(double z) {
  return std::clamp(static_cast<int>(z * kPerMetre + kSlices / 2), 0, kSlices - 1);
}

void FingerStrip::add(double height, double z) {
  double& h = highest[static_cast<std::size_t>(slice(z))];
  h = std::max(h, height);
}

double FingerStrip::height(double low, double high) const {
  double h = kNoStone;
  for (int i = first_slice(low); i <= last_slice(high); ++i)
    h = std::max(h, highest[static_cast<std::size_t>(i)]);
  return h;
}

FingerStrips cut_strips(const GripperModel& gripper, const GripperView& view, double y) {
  const double half_spacing = gripper.finger_spacing / 2, half_width = gripper.finger_width / 2;
  FingerStrips cut(1 + static_cast<std::size_t>(gripper.against));
  const std::span<FingerStrip> strips = cut.all();
  for (std::size_t f = 0; f < strips.size(); ++f) {
    strips[f].y = y + std::array{0.0, half_spacing, -half_spacing}[f];
    strips[f].side = f == 0 ? 1.0 : -1.0;
    strips[f].highest.fill(kNoStone);
  }
  for (std::size_t i = 0; i < view.p_T.size(); ++i)
    for (FingerStrip& strip : strips)
      if (const Eigen::Vector3d& p = view.p_T[i]; std::abs(p.y() - strip.y) <= half_width) {
        strip.add(strip.side * p.x(), p.z());
        strip.points.push_back(i);
      }
  return cut;
}

double turn_of_pads(const GripperModel& gripper, const GripperView& view, double tip) {
  const double half_width = gripper.finger_width / 2;
  const int first = FingerStrip::first_slice(tip - gripper.pad_length), last = FingerStrip::last_slice(tip);
  std::array<double, 4> height;  // of A at -y and +y, of B likewise
  height.fill(kNoStone);
  for (const Eigen::Vector3d& p : view.p_T) {
    if (std::abs(p.y()) > half_width) continue;
    const int at = FingerStrip::slice(p.z());
    if (at < first || at > last) continue;
    const std::size_t half = p.y() > 0.0 ? 1 : 0;
    height[half] = std::max(height[half], p.x());
    height[2 + half] = std::max(height[2 + half], -p.x());
  }
  if (*std::min_element(height.begin(), height.end()) == kNoStone) return 0.0;
  return 0.5 *
         (std::atan2(height[0] - height[1], half_width) + std::atan2(height[3] - height[2], half_width));
}

std::array<double, 2> heights_of_b_and_c(const GripperModel& gripper, const GripperView& view, double tip) {
  const double half_width = gripper.finger_width / 2;
  const std::array<double, 2> y{gripper.finger_spacing / 2, -gripper.finger_spacing / 2};
  const int first = FingerStrip::first_slice(tip - gripper.pad_length), last = FingerStrip::last_slice(tip);
  std::array<double, 2> height{kNoStone, kNoStone};
  for (const Eigen::Vector3d& p : view.p_T)
    for (std::size_t f = 0; f < 2; ++f) {
      if (std::abs(p.y() - y[f]) > half_width || -p.x() <= height[f]) continue;
      const int at = FingerStrip::slice(p.z());
      if (at >= first && at <= last) height[f] = -p.x();
    }
  return height;
}

double pad_height(const GripperModel& gripper, const FingerStrip& strip, double tip) {
  return strip.height(tip - gripper.pad_length, tip);
}

PadTouch touched(const GripperModel& gripper, std::span<const SurfaceSample> surface, double softness,
                 const GripperView& view, const FingerStrip& strip, double tip, double low, double high) {
  PadTouch touch;
  touch.height = pad_height(gripper, strip, tip);
  double area = 0.0;
  for (const std::size_t i : strip.points) {
    const Eigen::Vector3d& p = view.p_T[i];
    if (p.z() > tip || p.z() < tip - gripper.pad_length || strip.side * p.x() < touch.height - softness ||
        p.y() < low || p.y() > high)
      continue;
    touch.p += surface[i].area * surface[i].point;
    touch.n += surface[i].area * surface[i].normal;
    area += surface[i].area;
  }
  if (area <= 0.0 || touch.n.norm() < 1e-12) return {};
  touch.p /= area;
  touch.n.normalize();
  return touch;
}

}  // namespace stonestack::motion

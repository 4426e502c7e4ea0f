// One control step of the current command: where the joints shall be next, and whether they may.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "emulators/ur/motion.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kStepTiny = 1e-9;
constexpr double kOverspeed = 1.02;   // of a joint's limit: what stops the arm
constexpr double kPressGain = 0.002;  // m/s a N
constexpr double kTurnGain = 0.02;    // rad/s a Nm

Eigen::Matrix3d turned(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle < kStepTiny) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

}  // namespace

Pose Motion::compose(const Pose& start, const Six& displacement) const {
  Pose pose = start;
  pose.translation() += displacement.head<3>();
  pose.linear() = turned(displacement.tail<3>()) * start.rotation();
  return pose;
}

Six Motion::Move::displacement_at(double share) const {
  Six part = share * displacement;
  if (!n_B_arc.isZero()) part.head<3>() = turned(share * n_B_arc) * p_B_spoke - p_B_spoke;
  return part;
}

// The path continues from their ends. (A program may blend moves for hours; each step visits all moves.)
void Motion::leave_finished_moves() {
  std::size_t over = 0;
  while (over + 1 < moves_.size() && moves_[over].t >= moves_[over].profile.duration()) {
    q_start_ += moves_[over].displacement;
    T_B_start_ = compose(T_B_start_, moves_[over].displacement_at(1.0));
    ++over;
  }
  moves_.erase(moves_.begin(), moves_.begin() + static_cast<std::ptrdiff_t>(over));
}

bool Motion::next_moves(double seconds, Joints& q) {
  leave_finished_moves();
  Six sum = Six::Zero();
  Pose pose = T_B_start_;
  bool all_over = true;
  for (auto& move : moves_) {
    move.t += seconds;
    const double share =
        move.profile.length > kStepTiny ? move.profile.displacement(move.t) / move.profile.length : 1.0;
    sum += share * move.displacement;
    pose = compose(pose, move.displacement_at(share));
    all_over = all_over && move.t >= move.profile.duration();
  }
  q = q_start_ + sum;
  if (line_ && !geometry_.inverse(pose, q_unpressed_, true, q)) return false;
  if (all_over) {
    mode_ = Mode::kRest;
    moves_.clear();
  }
  return true;
}

bool Motion::next_servo(double seconds, Joints& q) {
  const double w = 2.0 / servo_lag_;
  // Exact step of q'' = w^2 (target - q) - 2 w q'.
  const Joints error = q_unpressed_ - servo_target_;
  const double decay = std::exp(-w * seconds);
  q = servo_target_ + decay * (error + seconds * (qd_ + w * error));
  elapsed_ += seconds;
  return true;
}

bool Motion::next_speed(double seconds, Joints& q) {
  const Six change = speed_target_ - speed_;
  const double change_norm = change.cwiseAbs().maxCoeff();
  const double max = speed_acceleration_ * seconds;
  const Six before = speed_;
  speed_ = change_norm <= max ? speed_target_ : Six(speed_ + change * (max / change_norm));
  const Six displacement = 0.5 * seconds * (before + speed_);
  elapsed_ += seconds;
  q = q_unpressed_ + displacement;
  if (!line_) return true;
  T_B_speed_ = compose(T_B_speed_, displacement);
  return geometry_.inverse(T_B_speed_, q_unpressed_, true, q);
}

// Compliant axes yield until the external force balances the commanded force.
bool Motion::press(double seconds, const Six& wrench_B, Joints& q) {
  const Eigen::Matrix3d R = force_.T_B_task.rotation();
  Six felt, speed = Six::Zero();
  felt << R.transpose() * wrench_B.head<3>(), R.transpose() * wrench_B.tail<3>();
  for (int i = 0; i < 6; ++i)
    if (force_.selection[i] != 0)
      speed[i] = std::clamp((i < 3 ? kPressGain : kTurnGain) * (force_.wrench[i] + felt[i]),
                            -std::abs(force_.limits[i]), std::abs(force_.limits[i]));
  shift_.head<3>() += seconds * (R * speed.head<3>());
  shift_.tail<3>() += seconds * (R * speed.tail<3>());
  return geometry_.inverse(compose(geometry_.T_B_P(q), shift_), q_, true, q);
}

std::string Motion::judge(const Joints& q, double seconds) const {
  const auto& robot = geometry_.robot();
  for (int j = 0; j < 6; ++j) {
    const double speed = std::abs(q[j] - q_[j]) / seconds;
    if (!std::isfinite(q[j])) return concat("joint ", j + 1, " has no finite target");
    if (q[j] > robot.upper[j] + 1e-6 || q[j] < robot.lower[j] - 1e-6)
      return concat("joint ", j + 1, " at its position limit (", q[j], " rad)");
    if (speed > kOverspeed * robot.velocity[j])
      return concat("joint ", j + 1, " faster than its limit (", speed, " rad/s)");
  }
  return {};
}

std::string Motion::step(double seconds, const Six& wrench_B) {
  Joints q = q_unpressed_;
  bool reached = true;
  if (seconds <= kStepTiny) {
    qd_.setZero();
    qdd_.setZero();
    return {};
  }
  auto command =
      std::tuple(mode_, moves_, q_start_, T_B_start_, elapsed_, speed_, T_B_speed_, shift_);  // as it was
  const auto refuse = [&](const std::string& reason) {
    std::tie(mode_, moves_, q_start_, T_B_start_, elapsed_, speed_, T_B_speed_, shift_) = std::move(command);
    qd_.setZero();
    qdd_.setZero();
    return reason;
  };
  if (mode_ == Mode::kMoves) reached = next_moves(seconds, q);
  if (mode_ == Mode::kServo) reached = next_servo(seconds, q);
  if (mode_ == Mode::kSpeed) reached = next_speed(seconds, q);
  if (!reached) return refuse("the target is out of reach or too close to a singularity");
  const Joints unpressed = q;
  if (force_.active && !press(seconds, wrench_B, q)) return refuse("force mode leaves the reach");
  if (const auto reason = judge(q, seconds); !reason.empty()) return refuse(reason);
  const Joints qd = (q - q_) / seconds;
  qdd_ = (qd - qd_) / seconds;
  // A servo's filter needs its own speed at the step's end, not the mean over the step.
  if (mode_ == Mode::kServo) {
    const double w = 2.0 / servo_lag_, decay = std::exp(-w * seconds);
    const Joints error = q_unpressed_ - servo_target_;
    qd_ = decay * (qd_ - w * seconds * (qd_ + w * error));
  } else if (mode_ == Mode::kSpeed && !line_) {
    qd_ = speed_;
  } else {
    qd_ =
        mode_ == Mode::kRest && !force_.active ? Joints(Joints::Zero()) : qd;  // a move's last, partial step
  }
  q_unpressed_ = unpressed;
  q_ = q;
  return {};
}

}  // namespace stonestack::emulators

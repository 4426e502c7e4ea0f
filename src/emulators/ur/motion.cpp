// The commands: what each asks for from now on. How it comes about step by step stands in motion_step.cpp.
#include "emulators/ur/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stonestack::emulators {
namespace {

constexpr double kEquivalentRadius =
    0.25;  // m, compares turning with moving; as in the configuration package
constexpr double kTiny = 1e-9;
constexpr double kMaxAcceleration = 100;  // rad/s^2 or m/s^2: what scripts may ask for

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

double bounded(double value, double max) {
  return std::clamp(value, 1e-3, max);
}

}  // namespace

Motion::Motion(const RobotModel& robot, const Joints& q)
    : geometry_(robot), q_(q), q_start_(q), q_unpressed_(q) {}

Six Motion::corner() const {
  Six sum = Six::Zero();
  for (const auto& move : moves_) sum += move.displacement;
  return sum;
}

// Goes on from moves that blend into the next; anything else that still moves is braked beside it.
void Motion::begin_moves(bool line, double acceleration) {
  const bool blends = mode_ == Mode::kMoves && line == line_ && !moves_.empty() && moves_.back().blend > 0;
  if (blends) return;
  Six speed = qd_;
  if (line) speed = geometry_.twist(q_unpressed_, qd_);
  moves_.clear();
  mode_ = Mode::kMoves;
  line_ = line;
  q_start_ = q_unpressed_;
  T_B_start_ = geometry_.T_B_P(q_unpressed_);
  const double fastest = speed.cwiseAbs().maxCoeff();
  if (fastest < 1e-6) return;
  const Profile brake = make_brake(fastest, acceleration);
  moves_.push_back({speed / fastest * brake.length, brake, 0.0, 0.0});
}

void Motion::push(const Six& displacement, double length, const MoveOptions& options, double blend) {
  const double a = bounded(options.acceleration, kMaxAcceleration);
  Move move;
  move.displacement = displacement;
  if (length > kTiny)
    move.profile = options.seconds > 0 ? make_timed_profile(length, options.seconds)
                                       : make_profile(length, bounded(options.speed, 100.0), a);
  move.blend = std::min(blend, 0.5 * length);
  moves_.push_back(move);
}

void Motion::move_joints(const Joints& q, const MoveOptions& options) {
  begin_moves(false, bounded(options.acceleration, kMaxAcceleration));
  const Joints start = q_start_ + corner();
  const Joints displacement = q - start;
  MoveOptions limited = options;
  const Joints& fastest = geometry_.robot().velocity;
  const double length = displacement.cwiseAbs().maxCoeff();
  for (int j = 0; j < 6; ++j)
    if (std::abs(displacement[j]) > kTiny)
      limited.speed = std::min(limited.speed, fastest[j] * length / std::abs(displacement[j]));
  // A blend radius is a distance of the tool: converts it to a part of the joint displacement.
  const double tool_distance =
      (geometry_.T_B_P(q).translation() - geometry_.T_B_P(start).translation()).norm();
  push(displacement, length, limited, tool_distance > kTiny ? options.blend / tool_distance * length : 0.0);
}

void Motion::move_line(const Pose& T_B_P, const MoveOptions& options) {
  begin_moves(true, bounded(options.acceleration, kMaxAcceleration));
  Pose start = T_B_start_;
  for (const auto& move : moves_) start = compose(start, move.displacement);
  Six displacement;
  displacement << T_B_P.translation() - start.translation(),
      rotation_vector(T_B_P.rotation() * start.rotation().transpose());
  const double length =
      std::max(displacement.head<3>().norm(), kEquivalentRadius * displacement.tail<3>().norm());
  push(displacement, length, options, options.blend);
}

void Motion::move_arc(const Pose& via, const Pose& T_B_P, const MoveOptions& options) {
  move_line(T_B_P, options);
  auto& move = moves_.back();
  const Eigen::Vector3d p1 = T_B_P.translation();
  const Eigen::Vector3d p0 = p1 - move.displacement.head<3>();
  const Eigen::Vector3d u = via.translation() - p0, w = p1 - p0;
  const Eigen::Vector3d n = u.cross(w);
  if (n.squaredNorm() < 1e-14) return;
  // Circumcentre of the triangle, seen from p0.
  const Eigen::Vector3d centre =
      (u.squaredNorm() * w.cross(n) + w.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
  const auto angle_to = [&](const Eigen::Vector3d& p) {
    const double angle =
        std::atan2(n.normalized().dot((-centre).cross(p - centre)), (-centre).dot(p - centre));
    return angle < 0 ? angle + 2 * std::numbers::pi : angle;
  };
  const double angle = angle_to(w);
  move.n_B_arc = angle * n.normalized();
  move.p_B_spoke = -centre;
  const Six displacement = move.displacement;
  const double length = std::max(angle * centre.norm(), kEquivalentRadius * displacement.tail<3>().norm());
  const Move arc = move;
  moves_.pop_back();
  push(displacement, length, options, options.blend);
  moves_.back().n_B_arc = arc.n_B_arc;
  moves_.back().p_B_spoke = arc.p_B_spoke;
}

void Motion::servo(const Joints& q, double seconds, double lookahead, double gain) {
  mode_ = Mode::kServo;
  moves_.clear();
  servo_target_ = q;
  servo_lag_ = std::clamp(lookahead, 0.03, 0.2) + 4.0 / std::clamp(gain, 100.0, 2000.0);
  elapsed_ = 0.0;
  hold_ = seconds;
}

void Motion::begin_speed(bool line, const Six& target, double acceleration, double seconds) {
  if (mode_ != Mode::kSpeed || line_ != line) {
    speed_ = qd_;
    if (line) speed_ = geometry_.twist(q_unpressed_, qd_);
    T_B_speed_ = geometry_.T_B_P(q_unpressed_);
  }
  moves_.clear();
  mode_ = Mode::kSpeed;
  line_ = line;
  speed_target_ = target;
  speed_acceleration_ = bounded(acceleration, 1000.0);
  elapsed_ = 0.0;
  hold_ = seconds;
}

void Motion::speed_joints(const Joints& qd, double acceleration, double seconds) {
  begin_speed(false, qd, acceleration, seconds);
}

void Motion::speed_line(const Six& twist, double acceleration, double seconds) {
  begin_speed(true, twist, acceleration, seconds);
}

void Motion::stop_joints(double acceleration) {
  begin_speed(false, Six::Zero(), acceleration, -1.0);
}

void Motion::stop_line(double acceleration) {
  begin_speed(true, Six::Zero(), acceleration, -1.0);
}

void Motion::freeze() {
  mode_ = Mode::kRest;
  moves_.clear();
  speed_.setZero();
  qd_.setZero();
  qdd_.setZero();
  force_.active = false;
  shift_.setZero();
  q_unpressed_ = q_;
}

void Motion::set_force_mode(const ForceMode& mode) {
  if (!mode.active) {
    shift_.setZero();
    q_unpressed_ = q_;
    if (mode_ != Mode::kSpeed) mode_ = Mode::kRest;
    moves_.clear();
    T_B_speed_ = geometry_.T_B_P(q_);
  }
  force_ = mode;
}

void Motion::set_tool(const Pose& T_F_P) {
  const Pose T_old_new = geometry_.T_F_P.inverse() * T_F_P;
  geometry_.T_F_P = T_F_P;
  T_B_start_ = T_B_start_ * T_old_new;
  T_B_speed_ = T_B_speed_ * T_old_new;
  if (!force_.active) return;
  shift_.head<3>() = geometry_.T_B_P(q_).translation() - geometry_.T_B_P(q_unpressed_).translation();
}

Pose Motion::T_B_waypoint() const {
  if (mode_ != Mode::kMoves || moves_.empty()) return geometry_.T_B_P(q_);
  if (!line_) return geometry_.T_B_P(q_start_ + corner());
  Pose pose = T_B_start_;
  for (const auto& move : moves_) pose = compose(pose, move.displacement);
  return pose;
}

bool Motion::moving() const {
  return qd_.cwiseAbs().maxCoeff() > 1e-6;
}

bool Motion::done() const {
  switch (mode_) {
    case Mode::kRest:
      return true;
    case Mode::kMoves: {
      if (moves_.empty()) return true;
      const auto& move = moves_.back();
      return move.profile.length - move.profile.displacement(move.t) <= move.blend + kTiny;
    }
    case Mode::kServo:
      return elapsed_ >= hold_ - kTiny;
    case Mode::kSpeed:
      return hold_ >= 0 ? elapsed_ >= hold_ - kTiny : speed_ == speed_target_;
  }
  return true;
}

}  // namespace stonestack::emulators

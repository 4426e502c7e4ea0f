#include "emulators/ur/controller.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kLongSinceBoot = 100.0;  // s: clients wait for 40
constexpr double kPowerSeconds = 1.0;     // a step of the sequence from power off to brakes released
constexpr double kUnlockAfter = 5.0;      // s
constexpr double kRounding = 1e-9;        // s, of times on the control step
constexpr double kHarder = 20.0;          // N, than when a stop was acknowledged: the arm is pushed on
constexpr double kTouchLeft = 0.2;        // rad of a joint, in which a touch is left
constexpr double kApart = 0.2;            // s; links are looked at every 50 ms
constexpr double kScalingRate = 5.0;      // 1/s, how fast the speed slider and a pause take effect
constexpr std::size_t kHistory = 1000;    // control steps
constexpr int kPathDeviation = 153, kCollision = 157;  // C-codes of protective stops
constexpr int kWarning = 2;                            // report level
constexpr std::uint64_t kEarlyCheck = 13;   // every so many steps RTDE samples before a script is through
constexpr double kStopAcceleration = 10.0;  // rad/s^2 when a program ends in motion
// rad/s^2 of the fastest joint: a UR5's base joint stops from 183 deg/s in 244 ms (UR5 CB3 user manual, A.1).
constexpr double kProtectiveDeceleration = 13.0;
constexpr std::uint32_t kFirstWithSensor = 5;  // PolyScope of the e-Series

}  // namespace

UrVersion parse_ur_version(const std::string& text) {
  UrVersion version;
  std::uint32_t* parts[] = {&version.major, &version.minor, &version.bugfix, &version.build};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (auto* part : parts) {
    const auto [next, error] = std::from_chars(at, end, *part);
    require(error == std::errc(), "a PolyScope version reads like 3.15.8.106339, got \"", text, "\"");
    at = next;
    if (at == end) break;
    require(*at++ == '.', "a PolyScope version reads like 3.15.8.106339, got \"", text, "\"");
  }
  require(version.major == 3 || version.major == 5 || version.major == 10,
          "the simulated controller is a CB3 (3.x), an e-Series (5.x) or PolyScope X (10.x), not ", text);
  return version;
}

bool has_own_sensor(const UrServerOptions& options) {
  return parse_ur_version(options.version).major >= kFirstWithSensor;
}

UrController::UrController(const UrServerOptions& options, const RobotModel& robot, Plant& plant)
    : faults(options.faults),
      motion(robot, plant.state().q),
      options_(options),
      version_(parse_ur_version(options.version)),
      plant_(&plant),
      period_(1.0 / version_.control_rate()),
      start_(options.faults.boot_seconds >= 0 ? options.faults.boot_seconds : kLongSinceBoot),
      measured_(plant.state()),
      has_sensor_(has_own_sensor(options)) {
  power_goal_ = robot_mode;
  speed_slider = faults.speed_slider;
  set_payload(options.payload, options.payload_cog);
}

bool UrController::can_move() const {
  return robot_mode == RobotMode::kRunning && safety_mode == SafetyMode::kNormal;
}

void Registers::write_int(std::size_t i, std::int32_t value, std::uint64_t step) {
  auto& write = writes_[i];
  if (write.step == step && out_int[i] != value) {
    write.over = out_int[i];
    write.over_step = step;
  }
  write.step = step;
  out_int[i] = value;
}

std::int32_t Registers::seen_int(std::size_t i, std::uint64_t step) const {
  const auto& write = writes_[i];
  return write.over_step == step && step % kEarlyCheck == 0 ? write.over : out_int[i];
}

void UrController::step() {
  ++steps_;
  trigger_faults();
  if (unlock_asked_) unlock_asked_ = safety_mode == SafetyMode::kProtectiveStop && !unlock_protective_stop();
  change_power();
  watch();
  run_programs();
  move();
  measure();
}

void UrController::trigger_faults() {
  const auto due = [&](double& time) {
    if (time < 0 || uptime() < time) return false;
    time = -1.0;
    return true;
  };
  if (due(faults.protective_stop_at))
    protective_stop(kCollision, "Collision detected by joint: fault switch");
  if (due(faults.emergency_stop_at)) emergency_stop();
  if (faults.script_dies_after >= 0 && program_running() &&
      uptime() - program_started_ >= faults.script_dies_after) {
    const int line = program_line();
    end_program("PROGRAM_XXX_STOPPED");
    report({line, 1, "runtime_error: fault switch"}, nullptr);
  }
}

void UrController::change_power() {
  if (power_change_at_ < 0 || uptime() < power_change_at_ || robot_mode == power_goal_) return;
  robot_mode = robot_mode == RobotMode::kPowerOff  ? RobotMode::kPowerOn
               : robot_mode == RobotMode::kPowerOn ? RobotMode::kIdle
                                                   : power_goal_;
  power_change_at_ = robot_mode == power_goal_ ? -1.0 : uptime() + kPowerSeconds;
}

void UrController::power_on() {
  if (robot_mode != RobotMode::kPowerOff) return;
  power_goal_ = RobotMode::kIdle;
  power_change_at_ = uptime() + kPowerSeconds;
}

void UrController::release_brakes() {
  if (robot_mode == RobotMode::kRunning || safety_mode != SafetyMode::kNormal) return;
  power_goal_ = RobotMode::kRunning;
  power_change_at_ = uptime() + kPowerSeconds;
}

void UrController::power_off() {
  stop_program();
  motion.freeze();
  robot_mode = power_goal_ = RobotMode::kPowerOff;
  power_change_at_ = -1.0;
}

void UrController::protective_stop(int code, const std::string& reason) {
  if (safety_mode != SafetyMode::kNormal) return;
  stopped_at_ = uptime();
  if (program_running()) runtime_ = RuntimeState::kPausing;
  set_safety_mode(SafetyMode::kProtectiveStop);
  ControllerEvent error;
  error.kind = ControllerEvent::Kind::kErrorCode;
  error.code = code;
  // "Protective stops are reported as warnings by the robot" (UR's client library, primary_client.rst).
  error.level = kWarning;
  error.text = reason;
  emit(error);
}

bool UrController::unlock_protective_stop() {
  if (safety_mode != SafetyMode::kProtectiveStop || faults.refuse_unlock) return false;
  if (uptime() - stopped_at_ < kUnlockAfter - kRounding) return false;
  set_safety_mode(SafetyMode::kNormal);
  if (!measured_.hit.empty()) touched_ = Touched{measured_.q, measured_.force_R.norm(), uptime()};
  return true;
}

void UrController::emergency_stop() {
  power_off();
  set_safety_mode(SafetyMode::kRobotEmergencyStop);
}

void UrController::restart_safety() {
  power_off();
  set_safety_mode(SafetyMode::kNormal);
}

// Some clients know the mode from the messages alone.
void UrController::set_safety_mode(SafetyMode mode) {
  if (safety_mode == mode) return;
  safety_mode = mode;
  ControllerEvent event;
  event.kind = ControllerEvent::Kind::kSafetyMode;
  event.code = static_cast<int>(mode);
  emit(std::move(event));
}

void UrController::input_written(const std::string& name) {
  if (watchdog.period > 0 && name == watchdog.variable) watchdog.fed = uptime();
}

void UrController::watch() {
  if (watchdog.period <= 0 || !program_running()) return;
  if (uptime() - watchdog.fed <= watchdog.period + kRounding) return;
  if (watchdog.action == "stop") {
    stop_program();
  } else if (watchdog.action == "pause") {
    pause_program();
    watchdog.fed = uptime();
  }
}

std::vector<ControllerEvent> UrController::take_events() {
  std::vector<ControllerEvent> events;
  std::swap(events, events_);
  return events;
}

std::uint32_t UrController::robot_status_bits() const {
  const bool power = robot_mode >= RobotMode::kIdle;
  return (power ? 1U : 0U) | (program_running() ? 2U : 0U);
}

std::uint32_t UrController::safety_status_bits() const {
  switch (safety_mode) {
    case SafetyMode::kNormal:
      return 1U;
    case SafetyMode::kProtectiveStop:
      return 1U << 2 | 1U << 10;
    case SafetyMode::kRobotEmergencyStop:
      return 1U << 6 | 1U << 7 | 1U << 10;
    case SafetyMode::kFault:
      return 1U << 9 | 1U << 10;
  }
  return 0;
}

void UrController::set_payload(double mass, const Eigen::Vector3d& p_F_cog) {
  payload = mass;
  payload_cog = p_F_cog;
  zero_sensor();  // script manual, set_target_payload
}

void UrController::scale_speed() {
  const auto approach = [&](double& value, double goal, double rate) {
    value += std::clamp(goal - value, -rate * period_, rate * period_);
  };
  approach(slider_, std::clamp(speed_slider, 0.0, 1.0), kScalingRate);
  if (runtime_ == RuntimeState::kResuming && limiter_ > 0) runtime_ = RuntimeState::kPlaying;
  const bool stopped = safety_mode == SafetyMode::kProtectiveStop;
  const double speed = slider_ * motion.qd().cwiseAbs().maxCoeff();
  double rate = kScalingRate;
  if (stopped)
    rate = std::max(rate, kProtectiveDeceleration / std::max(speed, kProtectiveDeceleration * period_));
  approach(limiter_, stopped || program_held() ? 0.0 : 1.0, rate);
  if (runtime_ == RuntimeState::kPausing && limiter_ == 0) runtime_ = RuntimeState::kPaused;
}

void UrController::move() {
  scale_speed();
  if (robot_mode != RobotMode::kRunning) return;
  if (safety_mode != SafetyMode::kNormal && safety_mode != SafetyMode::kProtectiveStop) return;
  if (!program_ && scaling() == 0) motion.freeze();  // nobody goes on with it
  if (!program_ && motion.moving() && motion.done()) motion.stop_joints(kStopAcceleration);
  const std::string refused = motion.step(period_ * scaling(), wrench_at_tool());
  if (refused.empty()) return;
  limiter_ = 0.0;
  protective_stop(kPathDeviation, "Protective stop: " + refused);
}

// A real arm feels a collision by what its joints have to bear more than before: it can be moved away.
void UrController::watch_for_collisions() {
  const bool hit = !measured_.hit.empty();
  if (touched_ && !hit && uptime() - touched_->last > kApart) touched_.reset();
  if (!hit) return;
  if (touched_) touched_->last = uptime();
  const bool leaves = touched_ && measured_.force_R.norm() < touched_->force + kHarder &&
                      (measured_.q - touched_->q).cwiseAbs().maxCoeff() < kTouchLeft;
  if (leaves) return;
  touched_.reset();
  // What it ran into stops an arm sooner than its brakes do: a simulated one would be driven into it.
  limiter_ = 0.0;
  protective_stop(kCollision, "Collision detected by joint: " + measured_.hit);
}

Eigen::Vector3d UrController::force_before(std::size_t steps) const {
  if (estimates_.empty()) return tool_wrench().head<3>();
  return estimates_[std::min(steps, estimates_.size() - 1)] - estimate_zero_.head<3>();
}

/// Constant part of a raw reading, as users report it (cartesian_controllers #120: "over 20,000").
Six UrController::sensor_offset() {
  return (Six() << 1794.0, 393.0, 25406.0, -7.9, -17.5, -76.0).finished();
}

/// Force and torque at the flange, axes of F, that the weight of the payload makes.
Six UrController::payload_weight() const {
  const Eigen::Matrix3d R_F_B = motion.geometry().T_B_F(measured_.q).rotation().transpose();
  const Eigen::Vector3d weight = R_F_B * Eigen::Vector3d(0, 0, -payload * kGravity);
  Six wrench;
  wrench << weight, payload_cog.cross(weight);
  return wrench;
}

void UrController::zero_wrench() {
  estimate_zero_ = estimate_;
  zero_sensor();
}

void UrController::zero_sensor() {
  sensor_zero_ = sensed_ - payload_weight();
}

Six UrController::sensor_wrench() const {
  const Eigen::Matrix3d R_B_F = motion.geometry().T_B_F(measured_.q).rotation();
  const Six wrench_F = sensed_ - sensor_zero_ - payload_weight();
  Six wrench;
  wrench << R_B_F * wrench_F.head<3>(), R_B_F * wrench_F.tail<3>();
  return wrench;
}

/// `wrench` about the tool centre point.
Six UrController::wrench_at_tool() const {
  if (!has_sensor_) return tool_wrench();
  Six wrench = sensor_wrench();
  const auto& geometry = motion.geometry();
  const Eigen::Vector3d arm = geometry.T_B_F(measured_.q).rotation() * geometry.T_F_P.translation();
  wrench.tail<3>() -= arm.cross(Eigen::Vector3d(wrench.head<3>()));
  return wrench;
}

void UrController::measure() {
  const bool first = history_.empty();
  measured_ = plant_->step(motion.q(), period_);
  watch_for_collisions();
  history_.push_front(measured_.q);
  if (history_.size() > kHistory) history_.pop_back();
  const auto& geometry = motion.geometry();
  const Pose T_B_F = geometry.T_B_F(measured_.q);
  const Eigen::Matrix3d R_B_R = geometry.robot().T_R_D.rotation().transpose();
  feel(T_B_F, R_B_R * measured_.force_R, R_B_R * measured_.torque_R);
  estimates_.push_front(estimate_.head<3>());
  estimates_.resize(history_.size());
  if (first) zero_sensor();  // when it was switched on
}

void UrController::feel(const Pose& T_B_F, const Eigen::Vector3d& force_B, const Eigen::Vector3d& torque_B) {
  const Eigen::Matrix3d R_B_F = T_B_F.rotation();
  const Eigen::Vector3d weight(0, 0, -payload * kGravity);
  const Eigen::Vector3d force = force_B - weight;
  Eigen::Vector3d torque = torque_B;
  torque -= Eigen::Vector3d(R_B_F * payload_cog).cross(weight);
  torque -= Eigen::Vector3d(R_B_F * motion.geometry().T_F_P.translation()).cross(force);
  estimate_ << force, torque;
  if (measured_.sensed)
    sensed_ << measured_.sensed->force, measured_.sensed->torque;
  else
    sensed_ << R_B_F.transpose() * force_B, R_B_F.transpose() * torque_B;
}

}  // namespace stonestack::emulators

#include "hardware/ur/ur_link.hpp"

#include <limits>

#include "hardware/constants.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kNextState = 0.05;    // s to wait for a newer status
constexpr double kChecksumTime = 3.0;  // s: a controller sends ten states a second

PrimaryOptions primary_options(const UrArmOptions& options) {
  PrimaryOptions primary;
  primary.ports.clear();
  for (const int port : {options.primary_port, options.secondary_port, options.realtime_port})
    if (port > 0) primary.ports.push_back(port);
  primary.connect_timeout = options.rtde.connect_timeout;
  return primary;
}

}  // namespace

UrLink::UrLink(const UrArmOptions& o)
    : options(o),
      rtde({o.address, o.rtde_port}, served_recipe(o.address), o.rtde),
      primary(o.address, primary_options(o)),
      version(rtde.version()),
      registers(first_register(version)) {
  if (const auto other = other_safety_configuration(); !other.empty())
    throw DeviceError("UR arm at " + o.address, other, kCompareSafety);
  const UrStatus now = next_status();
  run_ = now.run > 0 && now.run < std::numeric_limits<int>::max() / 2 ? now.run : 0;
  stop_reason_ = find_safety_stop(now);
  if (registers == 0)
    log_warning("controller " + to_string(version) +
                " has registers 0..23 only; make sure that no fieldbus uses them");
  for (const std::string& name : rtde.missing())
    log_info("controller " + to_string(version) + " does not report " + name);
  heart_ = std::thread([this] { beat(); });
}

UrLink::~UrLink() {
  {
    const std::lock_guard lock(ending_mutex_);
    ending_ = true;
  }
  ending_changed_.notify_all();
  heart_.join();
}

UrStatus UrLink::status() const {
  return read_status(rtde.sample(), registers);
}

UrStatus UrLink::next_status() const {
  if (const auto sample = rtde.wait_for_next(Deadline::in(kNextState)))
    return read_status(*sample, registers);
  return status();
}

void UrLink::send_inputs() {
  if (starved_) return;
  const std::lock_guard lock(inputs_mutex_);
  heartbeat_ = heartbeat_ == std::numeric_limits<std::int32_t>::max() ? 1 : heartbeat_ + 1;
  rtde.send(0, {heartbeat_, force_count_, force_.x(), force_.y(), force_.z()});
}

void UrLink::send_force(const Eigen::Vector3d& force) {
  {
    const std::lock_guard lock(inputs_mutex_);
    force_ = force;
    force_count_ = force_count_ == std::numeric_limits<std::int32_t>::max() ? 1 : force_count_ + 1;
  }
  send_inputs();
}

/// Keeps the watchdog of running programs content and notes every stop, whether something moves or not. While
/// the link is down it goes on trying: the client sets the link up anew.
void UrLink::beat() {
  const auto period = std::chrono::duration<double>(kHeartbeatPeriod);
  std::unique_lock lock(ending_mutex_);
  while (!ending_changed_.wait_for(lock, period, [this] { return ending_; })) {
    lock.unlock();
    try {
      send_inputs();
      if (const auto stop = find_safety_stop(status()); !stop.empty()) disarm(stop);
    } catch (const Error& error) {
      log_debug(error.what());
    }
    lock.lock();
  }
}

std::string UrLink::stop_reason() const {
  const std::lock_guard lock(arming_mutex_);
  return stop_reason_;
}

void UrLink::disarm(const std::string& reason) {
  const std::lock_guard lock(arming_mutex_);
  if (stop_reason_.empty()) stop_reason_ = reason;
}

void UrLink::starve(const std::string& reason) {
  starved_ = true;
  disarm(reason);
}

void UrLink::rearm() {
  const UrStatus now = next_status();
  if (starved_ && (now.program_running || now.is_held()))
    throw DeviceError("UR arm at " + options.address, "a program still runs that could not be stopped",
                      "stop it on the pendant");
  if (const auto stop = find_safety_stop(now); !stop.empty())
    throw DeviceError("UR arm at " + options.address, stop,
                      "look at the arm, remove the cause and unlock it on the pendant");
  const std::lock_guard lock(arming_mutex_);
  stop_reason_.clear();
  starved_ = false;
}

std::optional<std::uint32_t> UrLink::wait_for_safety_checksum() const {
  return primary.wait_for_safety_checksum(Deadline::in(kChecksumTime));
}

std::string UrLink::other_safety_configuration() {
  primary.connect_if_lost();
  if (options.safety_checksum.empty()) return {};
  return describe_other_safety(wait_for_safety_checksum(), options.safety_checksum);
}

std::string UrLink::explain_silence() const {
  try {
    DashboardClient dashboard({options.address, options.dashboard_port});
    if (dashboard.is_in_remote_control() == false)
      return "the controller is in local control: switch to Remote on the pendant";
  } catch (const Error& error) {
    log_debug(error.what());
  }
  return "look at the pendant's log, and that no popup waits";
}

int UrLink::next_run() {
  return ++run_;
}

}  // namespace stonestack::hardware

#include "hardware/robotiq/ft_sensor.hpp"

#include <Eigen/Geometry>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "hardware/constants.hpp"
#include "hardware/robotiq/ft_link.hpp"
#include "hardware/wrench_readings.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr double kFtSensorTurn = 0.05;  // s between checks of the stop mark
constexpr double kRateWindow = 1.0;     // s

std::chrono::duration<double> seconds(double value) {
  return std::chrono::duration<double>(value);
}

}  // namespace

FieldList fields(FtSensorOptions& o) {
  return {
      user(field("link", o.link, "serial, ur_cap, or ur: the arm's own sensor (e-Series)")),
      user(field("device", o.device, "of link serial: path of the line")),
      field("unit", o.unit, {1, 247}, "", "Modbus unit; Robotiq manual: 9"),
      user(field("address", o.address, "of link ur_cap: the robot's controller")),
      field("port", o.port, {1, 65535}, "", "of Robotiq's UR cap"),
      field("start_timeout", o.start_timeout, {0.5, 60.0}, "s", "until the first reading"),
      field("listen", o.listen, {0.02, 10.0}, "s",
            "that a serial line is listened to before it is spoken to"),
      field("stale", o.stale, {0.01, 1.0}, "s", "older readings are an error"),
      user(
          field("max_force", o.max_force, {1.0, 1000.0}, "N", "on an axis; FT150 150, FT300 300, UR10e 100")),
      user(field("max_torque", o.max_torque, {0.1, 100.0}, "Nm",
                 "on an axis; FT150 15, FT300 30, e-Series 10")),
      field("stuck_samples", o.stuck_samples, {0, 100000}, "",
            "equal readings in a row that mean a dead sensor; 0: never"),
      user(field("yaw", o.yaw, {-3.2, 3.2}, "rad", "about z, from the flange's axes to the sensor's")),
  };
}

struct RobotiqFtSensor::Stream {
  FtSensorOptions options;
  std::string name;
  Stopwatch clock;
  FtLink link;
  Wrench zero;

  mutable std::mutex mutex;  // of all below
  std::condition_variable arrived;
  FtReading newest{};
  double newest_time = 0.0;  // s of `clock`
  double newest_host = 0.0;  // s of `host_seconds`
  long number = 0, returned = 0;
  int equal = 0;  // readings running that are the same
  FtStreamHealth health;
  std::deque<double> times;
  std::string problem;  // of the last attempt to start anew
  std::string firmware;

  std::atomic<bool> stop = false;
  std::thread thread;

  explicit Stream(const FtSensorOptions& o)
      : options(o),
        name(ft_name(o)),
        link(start_ft_link(o, Deadline::in(o.start_timeout).or_interrupt())),
        firmware(link.firmware) {
    thread = std::thread([this] { drain(); });
  }
  ~Stream() {
    stop = true;
    thread.join();
  }
  void drain();
  void restart();
  void keep(const FtReading& reading);
  [[nodiscard]] Wrench next(double patience);
  [[noreturn]] void fail_silent(double age) const;
};

void RobotiqFtSensor::Stream::drain() {
  double last_heard = clock.seconds();
  while (!stop) {
    bool lost = !link.stream;
    try {
      std::array<std::uint8_t, 512> bytes;
      if (!lost) {
        const IoResult got = link.stream->read_some(bytes, Deadline::in(kFtSensorTurn));
        lost = got.status == IoStatus::kClosed;
        link.parser.feed(std::span<const std::uint8_t>(bytes).first(got.bytes));
      }
      while (!lost) {
        const auto reading = link.parser.next();
        if (!reading) break;
        keep(*reading);
        last_heard = clock.seconds();
      }
      {
        const std::lock_guard lock(mutex);
        health.bad_bytes = link.parser.bad_bytes();
      }
      if (!lost && clock.seconds() - last_heard < kSilence) continue;
      restart();
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex);
      problem = error.what();
      link.stream.reset();
    }
    if (!link.stream) std::this_thread::sleep_for(seconds(kFtSensorTurn));
    last_heard = clock.seconds();
  }
}

void RobotiqFtSensor::Stream::restart() {
  {
    const std::lock_guard lock(mutex);
    ++health.restarts;
  }
  link.stream.reset();
  link = start_ft_link(options, Deadline::in(std::min(options.start_timeout, 2.0)));
  const std::lock_guard lock(mutex);
  problem.clear();
  firmware = link.firmware;
}

void RobotiqFtSensor::Stream::keep(const FtReading& reading) {
  const std::lock_guard lock(mutex);
  equal = number > 0 && reading == newest ? equal + 1 : 0;
  if (number > returned) ++health.skipped;
  newest = reading;
  newest_time = clock.seconds();
  newest_host = host_seconds();
  ++number;
  ++health.readings;
  times.push_back(newest_time);
  while (times.front() < newest_time - kRateWindow) times.pop_front();
  const double span = times.back() - times.front();
  health.rate = span > 0 ? static_cast<double>(times.size() - 1) / span : 0.0;
  arrived.notify_all();
}

void RobotiqFtSensor::Stream::fail_silent(double age) const {
  throw DeviceError(name,
                    concat("no reading for ", age, " s (allowed ", options.stale, " s)",
                           problem.empty() ? "" : "; starting it anew failed: " + problem),
                    "stop the motion; check cable and power of the sensor");
}

Wrench RobotiqFtSensor::Stream::next(double patience) {
  std::unique_lock lock(mutex);
  // What lies here already counts only if it is fresh.
  if (number > returned && clock.seconds() - newest_time > options.stale) returned = number;
  if (!arrived.wait_for(lock, seconds(patience), [this] { return number > returned; }))
    fail_silent(clock.seconds() - newest_time);
  returned = number;
  if (options.stuck_samples > 0 && equal >= options.stuck_samples)
    throw DeviceError(name, concat("repeats one reading, ", equal, " times running"),
                      "switch the sensor off and on; it no longer measures");
  Wrench wrench;
  wrench.force = {newest[0], newest[1], newest[2]};
  wrench.torque = {newest[3], newest[4], newest[5]};
  wrench.device_time = newest_time;
  wrench.host_time = newest_host;
  lock.unlock();
  require_in_range(name, wrench, options.max_force, options.max_torque);
  return wrench;
}

RobotiqFtSensor::RobotiqFtSensor(const FtSensorOptions& options)
    : stream_(std::make_unique<Stream>(options)) {}
RobotiqFtSensor::~RobotiqFtSensor() = default;

Wrench RobotiqFtSensor::read() {
  const Wrench raw = stream_->next(stream_->options.stale);
  const Eigen::AngleAxisd R_F_S(stream_->options.yaw, Eigen::Vector3d::UnitZ());
  Wrench wrench;
  wrench.force = R_F_S * (raw.force - stream_->zero.force);
  wrench.torque = R_F_S * (raw.torque - stream_->zero.torque);
  wrench.device_time = raw.device_time;
  wrench.host_time = raw.host_time;
  return wrench;
}

void RobotiqFtSensor::zero() {
  stream_->zero = mean_at_rest(stream_->name, [this] { return stream_->next(stream_->options.stale); });
}

FtStreamHealth RobotiqFtSensor::health() const {
  const std::lock_guard lock(stream_->mutex);
  return stream_->health;
}

std::string RobotiqFtSensor::firmware() const {
  const std::lock_guard lock(stream_->mutex);
  return stream_->firmware;
}

}  // namespace stonestack::hardware

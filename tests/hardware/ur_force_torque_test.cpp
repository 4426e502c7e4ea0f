// The arm's own force sensor against a scripted controller.
#include "hardware/ur/ur_force_torque.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "hardware/fake_rtde.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Versions as the controller reports them.
constexpr const char* kPolyScope512 = "00 13 76 00000005 0000000C 00000002 00000001";
constexpr const char* kPolyScope58 = "00 13 76 00000005 00000008 00000002 00000001";
constexpr const char* kPolyScope315 = "00 13 76 00000003 0000000F 00000008 00019F63";
constexpr const char* kPolyScope10 = "00 13 76 0000000A 00000007 00000000 00000001";

/// A controller whose sensor has the constant part that users report, and noise of 0.01 N.
struct OwnSensorBench {
  enum class Fate { kSteady, kLoaded, kShaken, kOverloaded, kTwisted, kStuck, kSilent, kRepeated };
  mutable std::atomic<Fate> fate{Fate::kSteady};
  std::atomic<long> sent{0};
  FakeRtde server;
  FtSensorOptions sensor;

  explicit OwnSensorBench(const char* version = kPolyScope512, const char* types = "DOUBLE,VECTOR6D")
      : server([=, this](int) {
          FakeRtdePlan plan;
          plan.replies = {{'V', {hex("00 04 56 01")}},
                          {'v', {hex(version)}},
                          {'O', {encode({RtdeKind::kSetupOutputs, std::string(1, '\1') + types})}},
                          {'S', {hex("00 04 53 01")}}};
          plan.data = [this](long) { return next(); };
          return plan;
        }) {
    sensor.link = kOwnSensorLink;
    sensor.stale = 0.3;  // other programs share this machine with the test
    sensor.max_force = 100.0;
    sensor.max_torque = 10.0;
    sensor.stuck_samples = 20;
  }

  std::string next() {
    const Fate now = fate;
    if (now == Fate::kSilent) return {};
    const long n = now == Fate::kRepeated ? sent.load() : ++sent;
    const double sign = n % 2 == 0 ? 1.0 : -1.0, noise = now == Fate::kStuck ? 0.0 : 0.01 * sign;
    std::array<double, 6> raw{1794.0 + noise, 393.0, 25406.0, -7.9, -17.5, -76.0};
    if (now == Fate::kLoaded) add(raw, {1.0, -2.0, 30.0, 0.1, 0.2, -0.3});
    if (now == Fate::kShaken) add(raw, {0, 0, 4.0 * sign, 0, 0, 0});
    if (now == Fate::kOverloaded) add(raw, {0, -100.5, 0, 0, 0, 0});
    if (now == Fate::kTwisted) add(raw, {0, 0, 0, 10.5, 0, 0});
    return encode(encode_data({1, {100.0 + 0.01 * static_cast<double>(n), raw}}, 2, true));
  }
  static void add(std::array<double, 6>& raw, const std::array<double, 6>& more) {
    for (std::size_t i = 0; i < raw.size(); ++i) raw[i] += more[i];
  }

  [[nodiscard]] UrArmOptions arm() const {
    UrArmOptions arm;
    arm.address = server.endpoint().address;
    arm.rtde_port = server.endpoint().port;
    arm.rtde.connect_timeout = arm.rtde.reply_timeout = 2.0;
    arm.rtde.retry_pause = 0.02;
    arm.rtde.attempts = 2;
    return arm;
  }
  /// Reads until what was sent before the change has passed.
  Wrench settle(UrForceTorque& own, Fate next) const {
    fate = next;
    for (int k = 0; k < 4; ++k) (void)own.read();
    return own.read();
  }
  /// Error that the sensor reports within some readings after the change; empty: none.
  std::string problem_after(UrForceTorque& own, Fate next, int readings = 100) const {
    fate = next;
    try {
      for (int k = 0; k < readings; ++k) (void)own.read();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return {};
  }
};
using Fate = OwnSensorBench::Fate;

std::string own_sensor_problem(const char* version, const char* types = "DOUBLE,VECTOR6D") {
  const OwnSensorBench bench(version, types);
  try {
    const UrForceTorque own(bench.arm(), bench.sensor);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return {};
}

TEST(OwnSensor, ReadsWhatActsOnTheFlangeBesideTheFirstReading) {
  const OwnSensorBench bench;
  UrForceTorque own(bench.arm(), bench.sensor);
  EXPECT_LT(own.read().force.norm(), 0.03) << "25 kN are the sensor's constant part";
  const Wrench loaded = bench.settle(own, Fate::kLoaded);
  EXPECT_LT((loaded.force - Eigen::Vector3d(1.0, -2.0, 30.0)).norm(), 0.03);
  EXPECT_LT((loaded.torque - Eigen::Vector3d(0.1, 0.2, -0.3)).norm(), 1e-9);
  EXPECT_NE(own.read().device_time, loaded.device_time) << "a reading is returned once";
  EXPECT_NEAR(loaded.host_time, host_seconds(), 60.0);
}

TEST(OwnSensor, IsZeroedInTheHost) {
  const OwnSensorBench bench;
  UrForceTorque own(bench.arm(), bench.sensor);
  (void)bench.settle(own, Fate::kLoaded);
  own.zero();
  EXPECT_LT(own.read().force.norm(), 0.03);
  const Wrench unloaded = bench.settle(own, Fate::kSteady);
  EXPECT_LT((unloaded.force - Eigen::Vector3d(-1.0, 2.0, -30.0)).norm(), 0.03);
  EXPECT_LT((unloaded.torque - Eigen::Vector3d(-0.1, -0.2, 0.3)).norm(), 1e-9);
}

TEST(OwnSensor, IsNotZeroedWhileSomethingShakes) {
  const OwnSensorBench bench;
  UrForceTorque own(bench.arm(), bench.sensor);
  (void)bench.settle(own, Fate::kShaken);
  EXPECT_THAT([&] { own.zero(); }, testing::ThrowsMessage<DeviceError>(HasSubstr("not at rest")));
}

TEST(OwnSensor, RefusesWhatIsBeyondItsRange) {
  for (const Fate fate : {Fate::kOverloaded, Fate::kTwisted}) {
    const OwnSensorBench bench;
    UrForceTorque own(bench.arm(), bench.sensor);
    EXPECT_THAT(bench.problem_after(own, fate),
                AllOf(HasSubstr("force sensor of the UR arm"), HasSubstr("beyond its range")));
  }
}

TEST(OwnSensor, RefusesReadingsThatAreOldRepeatedOrStuck) {
  for (const Fate fate : {Fate::kSilent, Fate::kRepeated}) {
    const OwnSensorBench bench;
    UrForceTorque own(bench.arm(), bench.sensor);
    const Stopwatch watch;
    EXPECT_THAT(bench.problem_after(own, fate), testing::ContainsRegex("old|no new reading"));
    EXPECT_LT(watch.seconds(), 10.0);
    bench.fate = Fate::kSteady;
    bool back = false;  // the client sets the link up anew
    for (const Stopwatch patience; !back && patience.seconds() < 30.0;)
      back = bench.problem_after(own, Fate::kSteady, 3).empty();
    EXPECT_TRUE(back);
  }
  const OwnSensorBench bench;
  UrForceTorque own(bench.arm(), bench.sensor);
  EXPECT_THAT(bench.problem_after(own, Fate::kStuck), HasSubstr("repeats one reading, 20 times"));
}

TEST(OwnSensor, RefusesControllersWithoutAUsableReading) {
  EXPECT_THAT(own_sensor_problem(kPolyScope315),
              AllOf(HasSubstr("3.15.8"), HasSubstr("no force sensor"), HasSubstr("ur_cap or serial")));
  EXPECT_THAT(own_sensor_problem(kPolyScope58), AllOf(HasSubstr("5.8.2"), HasSubstr("PolyScope 5.9")));
  EXPECT_THAT(own_sensor_problem(kPolyScope10), HasSubstr("PolyScope X"));
  EXPECT_THAT(own_sensor_problem(kPolyScope512, "DOUBLE,NOT_FOUND"), HasSubstr("ft_raw_wrench"));
}

}  // namespace
}  // namespace stonestack::hardware

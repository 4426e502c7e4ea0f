// Each fault of facts on the gripper's wires: a switch of the simulator, and what the client must do.
#include <gmock/gmock.h>

#include <array>

#include "core/byte_stream.hpp"
#include "emulators/robotiq/gripper_simulator.hpp"
#include "hardware/robotiq/three_finger_gripper.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

struct FaultBench {
  IdealGripperPlant plant;
  std::unique_ptr<GripperSimulator> simulator;
  ThreeFingerOptions options;

  explicit FaultBench(const std::string& preset = "tcp2018") {
    GripperSimulatorOptions served;
    served.port = 0;
    served.rtu = true;
    served.speed_up = 50.0;
    simulator = std::make_unique<GripperSimulator>(plant, served);
    options.preset = preset;
    options.modbus.port = simulator->endpoint().port;
    options.modbus.device = simulator->serial_path();
    options.modbus.reply_timeout = 0.3;
    options.poll = 0.002;
    options.echo_timeout = 0.2;
    options.activation_timeout = 2.0;
  }
  void arm(const ModbusFaults& faults) const { simulator->set_faults(faults); }
  void arm(const GripperFaults& faults) const { simulator->set_faults(faults); }
  [[nodiscard]] ThreeFingerGripper ready() const {
    ThreeFingerGripper gripper(options);
    gripper.activate();
    return gripper;
  }
};

struct WireFault {
  const char* name;
  int ModbusFaults::*fault;
  const char* message;  // of the error when it never ends
  bool tcp, rtu;
};
const std::array<WireFault, 9> kWireFaults{{
    {"no_reply", &ModbusFaults::no_reply, "no reply within 0.3 s", true, true},
    {"hang_up", &ModbusFaults::hang_up, "the connection was closed", true, false},
    {"delayed", &ModbusFaults::delayed, "within 0.3 s", true, false},
    {"wrong_unit", &ModbusFaults::wrong_unit, "", true, true},
    {"wrong_transaction", &ModbusFaults::wrong_transaction, "no reply within 0.3 s", true, false},
    {"wrong_count", &ModbusFaults::wrong_count, "", true, true},
    {"bad_crc", &ModbusFaults::bad_crc, "no frame with a right CRC", false, true},
    {"truncated", &ModbusFaults::truncated, "", true, true},
    {"garbage", &ModbusFaults::garbage, "", true, true},
}};

class EveryLink : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] static std::string preset() { return GetParam(); }
  [[nodiscard]] static bool applies(const WireFault& fault) {
    return preset() == "rtu" ? fault.rtu : fault.tcp;
  }
};

TEST_P(EveryLink, OneSpoiltReplyIsRepeated) {
  for (const auto& fault : kWireFaults) {
    if (!applies(fault)) continue;
    SCOPED_TRACE(fault.name);
    const FaultBench bench(preset());
    ThreeFingerGripper gripper = bench.ready();
    ModbusFaults faults;
    faults.*fault.fault = 1;
    faults.delay = 0.45;
    bench.arm(faults);
    EXPECT_TRUE(gripper.is_active());
    EXPECT_NEAR(gripper.move(0.1, 0.11, 15).opening, 0.1, 0.001);
  }
}

TEST_P(EveryLink, WithoutEndItIsADeviceErrorThatNamesDeviceAddressAndUnit) {
  for (const auto& fault : kWireFaults) {
    if (!applies(fault)) continue;
    SCOPED_TRACE(fault.name);
    FaultBench bench(preset());
    bench.options.modbus.attempts = 2;
    ThreeFingerGripper gripper = bench.ready();
    ModbusFaults faults;
    faults.*fault.fault = -1;
    faults.delay = 0.45;
    bench.arm(faults);
    const bool rtu = preset() == "rtu";
    const std::string where = rtu ? bench.options.modbus.device : std::to_string(bench.options.modbus.port);
    EXPECT_THAT(
        [&] { (void)gripper.status(); },
        ThrowsMessage<DeviceError>(AllOf(HasSubstr("Robotiq gripper at "), HasSubstr(where),
                                         HasSubstr(rtu ? "unit 9" : "unit 2"), HasSubstr(fault.message))));
    bench.arm(ModbusFaults{});
    EXPECT_TRUE(gripper.is_active()) << "the link must be usable again";
  }
}

TEST_P(EveryLink, FragmentsAndMergedFramesDoNoHarm) {
  const FaultBench bench(preset());
  ThreeFingerGripper gripper = bench.ready();
  ModbusFaults faults;
  faults.fragments = true;
  bench.arm(faults);
  EXPECT_TRUE(gripper.is_active());
  faults.fragments = false;
  faults.merged = -1;
  bench.arm(faults);
  EXPECT_TRUE(gripper.is_active());
  EXPECT_NEAR(gripper.move(0.1, 0.11, 15).opening, 0.1, 0.001);
}

TEST_P(EveryLink, ExceptionsAreNamedAndBusyIsRepeated) {
  const FaultBench bench(preset());
  ThreeFingerGripper gripper = bench.ready();
  for (const auto& [code, text] :
       {std::pair{1, "1 (illegal function)"}, std::pair{2, "2 (illegal data address)"},
        std::pair{3, "3 (illegal data value)"}, std::pair{4, "4 (device failure)"},
        std::pair{11, "11 (gateway target does not respond)"}, std::pair{77, "77 (not in the standard)"}}) {
    ModbusFaults faults;
    faults.exceptions = 1;
    faults.exception = code;
    bench.arm(faults);
    EXPECT_THAT([&] { (void)gripper.status(); }, ThrowsMessage<DeviceError>(HasSubstr(text)));
  }
  for (const int code : {5, 6}) {
    ModbusFaults faults;
    faults.exceptions = 2;
    faults.exception = code;
    bench.arm(faults);
    EXPECT_TRUE(gripper.is_active()) << code;
  }
}

INSTANTIATE_TEST_SUITE_P(ModbusFaults, EveryLink, testing::Values("tcp2018", "rtu"));

TEST(GripperFaults, AnActivationThatNeverCompletesTimesOut) {
  const FaultBench bench;
  ThreeFingerGripper gripper(bench.options);
  GripperFaults faults;
  faults.activation_hangs = true;
  bench.arm(faults);
  EXPECT_THAT([&] { gripper.activate(); },
              ThrowsMessage<DeviceError>(HasSubstr("the activation did not finish within")));
  bench.arm(GripperFaults{});
  gripper.activate();
  EXPECT_TRUE(gripper.is_active());
}

TEST(GripperFaults, AMajorFaultStopsEverythingUntilANewActivation) {
  const FaultBench bench;
  ThreeFingerGripper gripper = bench.ready();
  for (const int code : {0xD, 0xE, 0xF}) {
    GripperFaults faults;
    faults.fault = code;
    bench.arm(faults);
    EXPECT_FALSE(gripper.is_active());
    EXPECT_THAT(gripper.state().fault, HasSubstr("activate again"));
    EXPECT_THROW(gripper.move(0.1, 0.11, 15), DeviceError);
    gripper.activate();
    EXPECT_NEAR(gripper.move(0.1, 0.11, 15).opening, 0.1, 0.001);
  }
}

TEST(GripperFaults, AFaultDuringAMotionEndsIt) {
  const FaultBench bench;
  ThreeFingerGripper gripper = bench.ready();
  GripperFaults faults;
  faults.stuck_moving = true;
  bench.arm(faults);
  ThreeFingerOptions options = bench.options;
  options.move_margin = 0.1;
  ThreeFingerGripper impatient(options);
  EXPECT_THAT([&] { impatient.move(0.0, 0.11, 15); },
              ThrowsMessage<DeviceError>(HasSubstr("a motion of the fingers did not finish within")));
}

TEST(GripperFaults, ASpreadThatFailedIsCommandedAgain) {
  const FaultBench bench;
  ThreeFingerGripper gripper = bench.ready();
  GripperFaults faults;
  faults.ignored_writes = 2;  // the request and its repetition
  bench.arm(faults);
  EXPECT_THAT([&] { gripper.spread(0.042); }, ThrowsMessage<DeviceError>(HasSubstr("does not echo it")));
  bench.arm(GripperFaults{});
  gripper.spread(0.042);
  EXPECT_NEAR(gripper.status().axes[3].position, 220, 1);
}

TEST(GripperFaults, ALostRequestIsSentOnceMoreThenReported) {
  const FaultBench bench;
  ThreeFingerGripper gripper = bench.ready();
  GripperFaults faults;
  faults.ignored_writes = 1;
  bench.arm(faults);
  EXPECT_NEAR(gripper.move(0.1, 0.11, 15).opening, 0.1, 0.001);
  faults.ignored_writes = 1000;
  bench.arm(faults);
  EXPECT_THAT([&] { gripper.move(0.05, 0.11, 15); },
              ThrowsMessage<DeviceError>(HasSubstr("does not echo it")));
}

TEST(GripperFaults, AnOldStatusIsNotReportedAsTheNewOne) {
  // The gripper is still at its last request and reports it until it acts upon the next one.
  const FaultBench bench;
  ThreeFingerGripper gripper = bench.ready();
  EXPECT_NEAR(gripper.move(0.1, 0.11, 15).opening, 0.1, 0.001);
  GripperFaults faults;
  faults.echo_delay = 4.0;  // simulated: 80 ms
  bench.arm(faults);
  EXPECT_NEAR(gripper.move(0.05, 0.11, 15).opening, 0.05, 0.001);
}

TEST(GripperFaults, ContactReportedAtTheRequestIsNoObject) {
  const FaultBench bench;
  ThreeFingerGripper gripper = bench.ready();
  GripperFaults faults;
  faults.false_object = true;
  bench.arm(faults);
  EXPECT_FALSE(gripper.move(0.05, 0.11, 15).object);
}

TEST(GripperFaults, ASlowSlipShowsInTheOpeningAndThenAsALostObject) {
  FaultBench bench;
  ThreeFingerGripper gripper = bench.ready();
  bench.plant.set_obstacles({120, 120, 120, 256});
  const GripperState held = gripper.move(0.0, 0.11, 60);
  ASSERT_TRUE(held.object);
  GripperFaults faults;
  faults.slip = 10.0;
  bench.arm(faults);
  GripperState state = held;
  for (const Deadline limit = Deadline::in(10); state.object && !limit.over();) state = gripper.state();
  EXPECT_FALSE(state.object);
  EXPECT_LT(state.opening, held.opening - 0.01);
}

}  // namespace
}  // namespace stonestack::emulators

// `rearm_arm` against the simulated controller.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "emulators/ur/ur_controller_server.hpp"
#include "hardware/cell_config.hpp"
#include "hardware/ur/dashboard_client.hpp"
#include "script_bench.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/cell_file.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Rearm : public testing::Test {
 protected:
  void serve(const ControllerFaults& faults = {}, const std::string& version = "3.15.8.106339") {
    UrServerOptions options;
    options.faults = faults;
    options.version = version;
    options.speed = 4.0;
    server_ = std::make_unique<UrControllerServer>(options, robot_, plant_);
    server_->start();
    config_.arm.address = "127.0.0.1";
    config_.arm.rtde.stale_after = 1.0;
    const UrPorts ports = server_->ports();
    config_.arm.rtde_port = ports.rtde;
    config_.arm.primary_port = ports.primary;
    config_.arm.secondary_port = ports.secondary;
    config_.arm.realtime_port = ports.realtime;
    config_.arm.dashboard_port = ports.dashboard;
  }
  [[nodiscard]] DashboardClient dashboard() const {
    return DashboardClient({"127.0.0.1", config_.arm.dashboard_port});
  }
  /// Error that rearming throws, after its exit code; empty: none.
  [[nodiscard]] std::string problem() {
    try {
      (void)rearm_arm(config_, confirm_);
    } catch (const Error& error) {
      return concat(static_cast<int>(error.exit_code()), ' ', error.what());
    }
    return "";
  }

  RobotModel robot_ = read_robot("ur10");
  IdealPlant plant_{ScriptBench::start()};
  std::unique_ptr<UrControllerServer> server_;
  CellConfig config_;
  bool agrees_ = true;
  std::vector<std::string> questions_;
  const ConfirmRearming confirm_ = [this](const ControllerState& state, const std::string& meaning,
                                          const std::vector<std::string>& steps) {
    questions_.push_back(concat(to_text(state), "; ", meaning, ";"));
    for (const std::string& step : steps) questions_.back() += " " + step + ",";
    return agrees_;
  };
};

TEST_F(Rearm, FreesAProtectiveStopOnlyForAPersonWhoHasLooked) {
  serve();
  server_->protective_stop("Collision detected by joint: test");
  agrees_ = false;
  EXPECT_THAT(problem(), AllOf(HasSubstr("7 UR arm at 127.0.0.1"), HasSubstr("nobody confirmed")));
  EXPECT_EQ(dashboard().safety(), "PROTECTIVE_STOP");
  ASSERT_EQ(questions_.size(), 1U);
  EXPECT_THAT(questions_[0], AllOf(HasSubstr("safety PROTECTIVE_STOP"), HasSubstr("collision"),
                                   HasSubstr("unlock the protective stop")));
  agrees_ = true;
  const Rearming done = rearm_arm(config_, confirm_);  // within 5 s of the stop: it waits for the controller
  EXPECT_EQ(done.before.safety, "PROTECTIVE_STOP");
  EXPECT_EQ(done.after.safety, "NORMAL");
  EXPECT_EQ(done.after.robot_mode, "RUNNING");
  EXPECT_THAT(done.steps, ElementsAre("close the safety popup", "unlock the protective stop"));
  EXPECT_EQ(dashboard().safety(), "NORMAL");
  const Rearming again = rearm_arm(config_, [](const auto&...) -> bool { throw std::logic_error("asked"); });
  EXPECT_TRUE(again.steps.empty()) << "an arm that is ready needs nobody";
  EXPECT_THAT(rearming_json(done), HasSubstr("\"schema\": \"stonestack.rearm/1\""));
}

TEST_F(Rearm, ReportsAStopThatTheControllerKeeps) {
  ControllerFaults faults;
  faults.refuse_unlock = true;
  faults.protective_stop_at = 0.0;
  serve(faults);
  EXPECT_THAT(problem(), AllOf(HasSubstr("6 "), HasSubstr("Cannot unlock protective stop")));
  EXPECT_EQ(dashboard().safety(), "PROTECTIVE_STOP");
}

TEST_F(Rearm, AnEmergencyStopIsLeftToThePerson) {
  ControllerFaults faults;
  faults.emergency_stop_at = 0.0;
  serve(faults);
  for (int i = 0; i < 200 && dashboard().safety() == "NORMAL"; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_THAT(problem(), AllOf(HasSubstr("7 "), HasSubstr("emergency stop button of the robot is pressed"),
                               HasSubstr("release the button"), HasSubstr("stonestack rearm")));
  EXPECT_TRUE(questions_.empty()) << "there is nothing to agree to";
  EXPECT_EQ(dashboard().safety(), "ROBOT_EMERGENCY_STOP");
}

TEST_F(Rearm, SwitchesTheArmOnAndReleasesItsBrakes) {
  serve();
  dashboard().power_off();
  agrees_ = false;
  EXPECT_THAT(problem(), HasSubstr("nobody confirmed"));
  EXPECT_EQ(dashboard().robot_mode(), "POWER_OFF");
  agrees_ = true;
  const Rearming done = rearm_arm(config_, confirm_);
  EXPECT_THAT(done.steps, ElementsAre("switch the arm on", "release the brakes"));
  EXPECT_EQ(done.after.robot_mode, "RUNNING");
}

TEST_F(Rearm, LeavesAnotherArmAlone) {
  serve();
  dashboard().power_off();
  config_.arm.serial = "2099999999";
  EXPECT_THAT(problem(), AllOf(HasSubstr("serial number " + UrServerOptions().serial),
                               HasSubstr("arm.serial is 2099999999")));
  EXPECT_TRUE(questions_.empty());
  EXPECT_EQ(dashboard().robot_mode(), "POWER_OFF");
  config_.arm.serial = UrServerOptions().serial;
  EXPECT_EQ(problem(), "");
}

TEST_F(Rearm, RefusesALocalController) {
  ControllerFaults faults;
  faults.local_mode = true;
  faults.protective_stop_at = 0.0;
  serve(faults, "5.12.2.1101534");
  for (int i = 0; i < 200 && dashboard().safety() == "NORMAL"; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_THAT(problem(), AllOf(HasSubstr("7 "), HasSubstr("local control"), HasSubstr("Remote")));
  EXPECT_TRUE(questions_.empty());
}

TEST_F(Rearm, NeedsAnAddressAndAController) {
  EXPECT_THAT(problem(), HasSubstr("arm.address is missing"));
  config_.arm.address = "127.0.0.1";
  config_.arm.dashboard_port = 1;
  EXPECT_THAT(problem(), AllOf(HasSubstr("6 "), HasSubstr("127.0.0.1:1")));
}

}  // namespace
}  // namespace stonestack::emulators

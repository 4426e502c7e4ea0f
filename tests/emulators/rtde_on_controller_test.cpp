// The RTDE client against the simulated controller: all session ends that users report, one
// after the other, for as long as a working day has minutes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "emulators/ur/ur_controller_server.hpp"
#include "hardware/ur/rtde_client.hpp"
#include "script_bench.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using ::testing::HasSubstr;

constexpr double kRtdeLong = 20.0;  // s

struct Controller {
  explicit Controller(const ControllerFaults& faults, double speed = 1.0)
      : server(with(faults, speed), robot, plant) {
    server.start();
  }
  static UrServerOptions with(const ControllerFaults& faults, double speed) {
    UrServerOptions options;
    options.faults = faults;
    options.speed = speed;
    return options;
  }
  [[nodiscard]] Endpoint rtde() const { return {"127.0.0.1", server.ports().rtde}; }
  RobotModel robot = read_robot("ur10");
  IdealPlant plant{ScriptBench::start()};
  UrControllerServer server;
};

RtdeRecipe recipe(const UrVersion&) {
  return {{"actual_q", "input_int_register_24"}, {}, {{"input_int_register_24"}}};
}

RtdeOptions patient() {
  RtdeOptions options;
  options.retry_pause = 0.02;
  options.stale_after = 0.5;
  options.silent_after = 0.3;
  options.attempts = 200;
  return options;
}

/// Waits until `good` of the newest state, or for long.
template <class Good>
bool becomes(const RtdeClient& client, const Good& good) {
  for (const Deadline limit = Deadline::in(kRtdeLong); !limit.over();)
    if (const auto sample = client.wait_for_next(Deadline::in(1.0)); sample && good(*sample)) return true;
  return false;
}

struct LostSession {
  const char* how;
  double ControllerFaults::*at;
};

class EveryLostSession : public testing::TestWithParam<LostSession> {};

TEST_P(EveryLostSession, IsSetUpAnewFromTheFirstPacketOn) {
  ControllerFaults faults;
  faults.*GetParam().at = 1.0;
  Controller controller(faults);
  RtdeClient client(controller.rtde(), recipe, patient());
  EXPECT_EQ(client.counts().sessions, 1);
  bool reported = false;
  for (const Deadline limit = Deadline::in(kRtdeLong); client.counts().sessions < 2 && !limit.over();) {
    try {
      (void)client.sample();
    } catch (const DeviceError& error) {
      reported = true;
      EXPECT_THAT(error.what(), HasSubstr("nothing may move until the link is back"));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  // A link that is cut is back within the age that a state may have; silence and a restart are longer.
  if (std::string(GetParam().how) == "restarted") {
    EXPECT_TRUE(reported);
  }
  // The dying session has freed its register, and what is written takes effect.
  EXPECT_TRUE(becomes(client, [](const RtdeSample& now) { return now.device_time() > 100.0; }));
  client.send(0, {std::int32_t{7}});
  EXPECT_TRUE(becomes(
      client, [](const RtdeSample& now) { return now.get<std::int32_t>("input_int_register_24") == 7; }));
  EXPECT_EQ(client.counts().refused, 0);
}

INSTANTIATE_TEST_SUITE_P(Rtde, EveryLostSession,
                         testing::Values(LostSession{"silent", &ControllerFaults::drop_rtde_at},
                                         LostSession{"closed", &ControllerFaults::close_rtde_at},
                                         LostSession{"restarted", &ControllerFaults::restart_rtde_at}),
                         [](const auto& lost) { return std::string(lost.param.how); });

TEST(RtdeOnController, AStreamOutOfStepIsLeftAndMadeAnew) {
  ControllerFaults faults;
  faults.out_of_step = true;
  Controller controller(faults);
  const RtdeClient client(controller.rtde(), recipe, patient());
  for (const Deadline limit = Deadline::in(kRtdeLong); client.counts().sessions < 3 && !limit.over();)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GE(client.counts().sessions, 3) << "every session breaks at its tenth package";
  controller.server.set_faults({});
  EXPECT_TRUE(becomes(client, [](const RtdeSample&) { return true; }));
  const int sessions = client.counts().sessions;
  for (int k = 0; k < 30; ++k) EXPECT_TRUE(client.wait_for_next(Deadline::in(kRtdeLong)));
  EXPECT_LE(client.counts().sessions, sessions + 1) << "the last broken one may still have been open";
}

TEST(RtdeOnController, ABootingControllerIsWaitedFor) {
  ControllerFaults faults;
  faults.boot_seconds = 0.0;
  Controller controller(faults, 4.0);
  const RtdeClient client(controller.rtde(), recipe, patient());
  EXPECT_GE(client.sample().device_time(), 1.0 - 0.02) << "a second of steady data, as its clock is young";
  faults.boot_seconds = 60.0;
  Controller running(faults);
  const RtdeClient at_once(running.rtde(), recipe, patient());
  EXPECT_LT(at_once.counts().accepted, 100) << "by its clock it booted long ago";
}

long open_files() {
  long count = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

// Users report sockets that end after ten to twelve hours, for no reason that they know. Here a session ends
// every minute of the controller's clock, and each must be as good as the first.
TEST(RtdeOnController, ManySessionsAreAsGoodAsTheFirst) {
  Controller controller({}, 100.0);
  RtdeOptions options = patient();
  options.frequency = 5.0;
  RtdeClient client(controller.rtde(), recipe, options);
  const long files = open_files();
  std::int32_t beat = 0;
  double last = 0.0, cut_at = controller.server.time() + 60.0;
  int cuts = 0;
  for (const Deadline limit = Deadline::in(3 * kRtdeLong); cuts < 12 && !limit.over();) {
    const auto sample = client.wait_for_next(Deadline::in(kRtdeLong));
    ASSERT_TRUE(sample) << "after " << cuts << " sessions";
    EXPECT_GT(sample->device_time(), last);
    last = sample->device_time();
    try {
      client.send(0, {++beat});
    } catch (const DeviceError&) {  // between two sessions
    }
    if (controller.server.time() < cut_at) continue;
    controller.server.cut_rtde();
    cut_at += 60.0;
    ++cuts;
  }
  EXPECT_TRUE(becomes(client, [&](const RtdeSample&) { return client.counts().sessions == cuts + 1; }));
  EXPECT_EQ(cuts, 12);
  EXPECT_EQ(client.counts().refused, 0);
  EXPECT_EQ(client.counts().skipped, 0) << "no sample is missed while a session lasts";
  for (const Deadline limit = Deadline::in(kRtdeLong); open_files() > files && !limit.over();)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_LE(open_files(), files) << "neither end keeps what a session leaves behind";
}

}  // namespace
}  // namespace stonestack::emulators

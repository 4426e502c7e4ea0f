// The real UR backend against the simulated controller: generated scripts in its interpreter, and UrArm over
// its sockets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "emulators/ur/ur_controller_server.hpp"
#include "hardware/ur/script_writer.hpp"
#include "hardware/ur/ur_arm.hpp"
#include "motion/timing.hpp"
#include "script_bench.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {
namespace {

using Status = MotionResult::Status;
using ::testing::HasSubstr;

constexpr double kPathError = 1e-3;  // rad

/// Three corners, timed as the planner would.
JointTrajectory planned(double scale = 1.0) {
  const Joints start = ScriptBench::start();
  Joints far, back;
  far << 0.5, 0.3, -0.4, 0.2, 0.3, -0.5;
  back << 0.6, 0.1, -0.1, -0.2, 0.4, 0.3;
  TimingLimits limits;
  limits.velocity.setConstant(1.0);
  limits.acceleration.setConstant(1.4);
  return time_path({start, start + scale * far, start + scale * back}, limits);
}

ScriptContext context(const UrController& controller, int run) {
  ScriptContext c;
  c.version = controller.version();
  c.run = run;
  c.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
  return c;
}

/// Largest joint distance from `q` to the trajectory, at any time of it.
double distance_to(const JointTrajectory& trajectory, const Joints& q) {
  double nearest = 1e9;
  for (double t = 0; t <= trajectory.duration() + 1e-9; t += 0.001)
    nearest = std::min(nearest, (sample(trajectory, t).q - q).cwiseAbs().maxCoeff());
  return nearest;
}

/// Steps the controller, with a heartbeat every second step, until `done` or `seconds` are over.
void run_fed(ScriptBench& bench, double seconds, const std::function<void()>& each_step) {
  const double end = bench.controller.uptime() + seconds;
  for (int k = 0; bench.controller.uptime() < end; ++k) {
    if (k % 2 == 0) bench.controller.input_written("input_int_register_24");
    bench.run(bench.controller.period());
    each_step();
    if (bench.controller.runtime() == RuntimeState::kStopped && k > 2) return;
  }
}

TEST(UrScripts, TheInterpreterFollowsThePlannedTrajectory) {
  for (const char* version : {"3.15.8.106339", "3.8.0.1", "5.11.0.108249"}) {
    ScriptBench bench(version);
    const JointTrajectory trajectory = planned();
    bench.controller.run_script(write_trajectory(trajectory, context(bench.controller, 7)));
    const int first = first_register(bench.controller.version());
    double worst = 0.0, begin = bench.controller.uptime();
    int looks = 0;
    run_fed(bench, 3 * trajectory.duration() + 2, [&] {
      if (first == 0) bench.controller.input_written("input_int_register_0");
      if (looks++ % 5 == 0) worst = std::max(worst, distance_to(trajectory, bench.plant.state().q));
    });
    const double took = bench.controller.uptime() - begin;
    EXPECT_EQ(bench.exceptions, "") << version;
    EXPECT_LT(worst, kPathError) << version;
    EXPECT_LT((bench.plant.state().q - trajectory.q.back()).cwiseAbs().maxCoeff(), 0.0021) << version;
    EXPECT_LT(took, trajectory.duration() + 1.0);
    EXPECT_GT(took, trajectory.duration() - 0.1);
    const auto at = static_cast<std::size_t>(first);
    EXPECT_EQ(bench.controller.registers.out_int[at], 7);
    EXPECT_EQ(bench.controller.registers.out_int[at + 2], static_cast<int>(ScriptEnd::kDone)) << version;
    const Pose T_B_T = bench.robot.T_R_D.inverse() * forward(bench.robot, bench.plant.state().q) *
                       Pose(Eigen::Translation3d(0, 0, 0.264));
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(bench.controller.registers.out_double[at + i], T_B_T.translation()[static_cast<long>(i)],
                  1e-3);
  }
}

TEST(UrScripts, SilenceOfTheHostStopsTheProgram) {
  ScriptBench bench;
  bench.controller.run_script(write_trajectory(planned(), context(bench.controller, 7)));
  bench.run(0.3);  // not a single heartbeat
  EXPECT_EQ(bench.controller.runtime(), RuntimeState::kStopped);
  EXPECT_EQ(bench.controller.registers.out_int[24], 7);
  EXPECT_EQ(bench.controller.registers.out_int[26], static_cast<int>(ScriptEnd::kRunning));
  bench.run(1.0);
  const Joints rest = bench.plant.state().q;
  bench.run(0.5);
  EXPECT_EQ(bench.plant.state().q, rest);
}

TEST(UrScripts, ThePathWaitsForTheSpeedSlider) {
  ScriptBench bench;
  const JointTrajectory trajectory = planned();
  bench.controller.run_script(write_trajectory(trajectory, context(bench.controller, 7)));
  double worst = 0.0;
  int k = 0;
  run_fed(bench, 10 * trajectory.duration(), [&] {
    bench.controller.speed_slider = ++k < 100 ? 1.0 : k < 200 ? 0.0 : 0.5;
    if (k % 5 == 0) worst = std::max(worst, distance_to(trajectory, bench.plant.state().q));
  });
  EXPECT_EQ(bench.controller.registers.out_int[26], static_cast<int>(ScriptEnd::kDone));
  EXPECT_LT(worst, 0.02) << "no short cut across a corner";
}

/// Runs a guarded program; `force(t)` is the sensor's push against the motion, NaN: no new sample.
int run_guarded(ScriptBench& bench, const std::function<double(double)>& force) {
  bench.controller.run_script(write_guarded(planned(0.05), {}, context(bench.controller, 9)));
  const double begin = bench.controller.uptime();
  run_fed(bench, 10.0, [&] {
    const double push = force(bench.controller.uptime() - begin);
    if (std::isnan(push)) return;
    bench.controller.registers.in_double[26] = push;
    ++bench.controller.registers.in_int[25];
  });
  EXPECT_EQ(bench.exceptions, "");
  return bench.controller.registers.out_int[26];
}

TEST(UrScripts, GuardedMotionEndsAtContactOrSilence) {
  ScriptBench contact, none, silent, mute;
  EXPECT_EQ(run_guarded(contact, [](double t) { return t < 0.3 ? 20.0 : 27.0; }),
            static_cast<int>(ScriptEnd::kContact));
  EXPECT_NEAR(contact.controller.registers.out_double[30], 7.0, 1e-6) << "above the force at the start";
  EXPECT_GT(distance_to({{0.0}, {planned(0.05).q.back()}, {Joints::Zero()}}, contact.plant.state().q), 1e-3);
  EXPECT_EQ(run_guarded(none, [](double) { return 20.0; }), static_cast<int>(ScriptEnd::kNoContact));
  EXPECT_EQ(run_guarded(silent, [](double t) { return t < 0.25 ? 20.0 : NAN; }),
            static_cast<int>(ScriptEnd::kStaleForce));
  EXPECT_EQ(run_guarded(mute, [](double) { return NAN; }), static_cast<int>(ScriptEnd::kStaleForce));
  EXPECT_EQ(mute.plant.state().q, ScriptBench::start()) << "no force, no motion";
}

/// State of an arm whose program is paused, which is then moved by hand, and resumed.
struct Resumed {
  int end = 0;
  double fastest = 0.0;  ///< speed [rad/s] of any joint, after the pause
};

/// `knots`: paused once so many are passed. `shift`: rad, of every joint.
Resumed pause_move_resume(const std::string& script, int knots, double shift) {
  ScriptBench bench;
  UrController& c = bench.controller;
  const auto step = [&] {
    c.input_written("input_int_register_24");
    ++c.registers.in_int[25];  // force readings, for guarded programs
    bench.run(c.period());
  };
  c.run_script(script);
  for (int k = 0; k < 100; ++k) step();
  while (c.registers.out_int[25] < knots && c.program_running()) step();
  EXPECT_TRUE(c.pause_program());
  for (int k = 0; k < 100; ++k) step();
  Motion moved(bench.robot, bench.plant.state().q + Joints::Constant(shift));
  moved.set_tool(c.motion.geometry().T_F_P);
  c.motion = moved;
  step();
  EXPECT_TRUE(c.resume_program());
  Resumed resumed;
  for (int k = 0; k < 600; ++k) {
    const Joints before = bench.plant.state().q;
    step();
    const double speed = (bench.plant.state().q - before).cwiseAbs().maxCoeff() / c.period();
    resumed.fastest = std::max(resumed.fastest, speed);
  }
  EXPECT_EQ(bench.exceptions, "");
  resumed.end = c.registers.out_int[26];
  return resumed;
}

TEST(UrScripts, AnArmThatWasMovedInAPauseDoesNotJumpBack) {
  ScriptBench bench;
  const JointTrajectory path = planned();
  const ScriptContext nine = context(bench.controller, 9);
  const int last = static_cast<int>(path.time.size()) - 1;
  const std::string program = write_trajectory(path, nine), guarded = write_guarded(planned(0.3), {}, nine);
  for (const auto& [script, knots] :
       {std::pair(program, 0), std::pair(program, last), std::pair(guarded, 0)}) {
    const Resumed stopped = pause_move_resume(script, knots, 0.3);
    EXPECT_EQ(stopped.end, static_cast<int>(ScriptEnd::kFellBehind)) << knots;
    EXPECT_LT(stopped.fastest, 0.01) << knots;
    // Without the check it is what moves the arm, and how.
    std::string chasing = script;
    const auto limit = chasing.find("global stk_lag_end = ");
    ASSERT_NE(limit, std::string::npos);
    chasing.replace(limit, chasing.find('\n', limit) - limit, "global stk_lag_end = 1000.0");
    EXPECT_GT(pause_move_resume(chasing, knots, 0.3).fastest, 0.2) << knots;
  }
  EXPECT_EQ(pause_move_resume(program, 0, 0.0).end, static_cast<int>(ScriptEnd::kDone)) << "not moved";
}

/// UrArm on a server over loopback.
struct Loopback {
  explicit Loopback(const UrServerOptions& options = {}, ForceTorqueSensor* sensor = nullptr,
                    const std::string& safety = {})
      : safety_checksum(safety), server(options, robot, plant) {
    server.start();
    arm = std::make_unique<UrArm>(robot, arm_options(), Pose::Identity(),
                                  Pose(Eigen::Translation3d(0, 0, 0.264)), sensor);
  }
  [[nodiscard]] UrArmOptions arm_options() const {
    const auto or_closed = [](int port) { return port > 0 ? port : 1; };
    UrArmOptions o;
    o.address = "127.0.0.1";
    o.rtde_port = or_closed(server.ports().rtde);
    o.primary_port = or_closed(server.ports().primary);
    o.secondary_port = or_closed(server.ports().secondary);
    o.realtime_port = or_closed(server.ports().realtime);
    o.dashboard_port = or_closed(server.ports().dashboard);
    o.rtde.stale_after = o.script.force_stale = 1.0;  // a busy machine is not the point here
    o.script.heartbeat_rate = 2;
    o.safety_checksum = safety_checksum;
    o.pause_limit = 20.0;  // what is paused by a mistake of a test does not hold it up
    return o;
  }
  std::string safety_checksum;
  RobotModel robot = read_robot("ur10");
  IdealPlant plant{ScriptBench::start()};
  UrControllerServer server;
  std::unique_ptr<UrArm> arm;
};

TEST(UrArmOnController, FollowsSetsPayloadAndStops) {
  Loopback cell;
  cell.arm->set_payload(2.0, {0, 0, 0.1});
  const JointTrajectory there = planned(0.3);
  const MotionResult moved = cell.arm->follow(there);
  ASSERT_EQ(moved.status, Status::kDone) << moved.reason;
  EXPECT_LT((moved.q - there.q.back()).cwiseAbs().maxCoeff(), 0.0021);
  EXPECT_EQ(cell.arm->follow(there).status, Status::kRefused) << "the arm is not where it starts any more";
  cell.arm->stop();
  EXPECT_TRUE(cell.arm->state().can_move);
}

/// Somebody at the Dashboard while the arm follows a trajectory.
struct UrArmOnControllerPendant {
  explicit UrArmOnControllerPendant(Loopback& cell)
      : arm(*cell.arm),
        stream(TcpStream::connect({"127.0.0.1", cell.server.ports().dashboard}, Deadline::in(5))),
        motion([this] {
          moved = arm.follow(planned());
          over = true;
        }) {
    static_cast<void>(stream.read_line(1024, Deadline::in(5)));  // the greeting
    const Deadline limit = Deadline::in(20);
    while (!limit.over() && !over && (arm.state().q - ScriptBench::start()).cwiseAbs().maxCoeff() < 0.1)
      pass();
  }
  ~UrArmOnControllerPendant() {
    if (motion.joinable()) motion.join();
  }
  UrArmOnControllerPendant(const UrArmOnControllerPendant&) = delete;
  UrArmOnControllerPendant& operator=(const UrArmOnControllerPendant&) = delete;
  std::string ask(const std::string& command) {
    EXPECT_TRUE(stream.write_all(command + "\n", Deadline::in(5)));
    return stream.read_line(1024, Deadline::in(5)).line;
  }
  static void pass(int milliseconds = 5) {
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
  }

  UrArm& arm;
  TcpStream stream;
  MotionResult moved;
  std::atomic<bool> over{false};
  std::thread motion;
};

TEST(UrArmOnController, APauseAtTheDashboardIsWaitedForUntilPlay) {
  Loopback cell;
  UrArmOnControllerPendant pendant(cell);
  EXPECT_EQ(pendant.ask("pause"), "Pausing program");
  UrArmOnControllerPendant::pass(1000);  // a program that is gone is given 0.3 s
  EXPECT_FALSE(pendant.over);
  EXPECT_THAT(pendant.ask("programState"), HasSubstr("PAUSED stonestack_"));
  const Joints held = cell.arm->state().q;
  UrArmOnControllerPendant::pass(200);
  EXPECT_LT((cell.arm->state().q - held).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(pendant.ask("play"), "Starting program");
  pendant.motion.join();
  EXPECT_EQ(pendant.moved.status, Status::kDone) << pendant.moved.reason;
  EXPECT_LT((pendant.moved.q - planned().q.back()).cwiseAbs().maxCoeff(), 0.0021);
}

TEST(UrArmOnController, AfterTooLongAPauseNothingIsLeftToPlay) {
  Loopback cell;
  UrArmOptions options = cell.arm_options();
  options.pause_limit = 1.0;
  cell.arm.reset();
  cell.arm =
      std::make_unique<UrArm>(cell.robot, options, Pose::Identity(), Pose(Eigen::Translation3d(0, 0, 0.264)));
  UrArmOnControllerPendant pendant(cell);
  EXPECT_EQ(pendant.ask("pause"), "Pausing program");
  pendant.motion.join();
  EXPECT_EQ(pendant.moved.status, Status::kStopped);
  EXPECT_THAT(pendant.moved.reason, HasSubstr("paused by the user"));
  EXPECT_THAT(pendant.ask("programState"), HasSubstr("STOPPED"));
  const Joints held = cell.arm->state().q;
  EXPECT_EQ(pendant.ask("play"), "Failed to execute: play");
  UrArmOnControllerPendant::pass(300);
  EXPECT_LT((cell.arm->state().q - held).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(UrArmOnController, ProtectiveStopNeedsAPerson) {
  Loopback cell;
  std::thread fate([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    cell.server.protective_stop("test");
  });
  const MotionResult moved = cell.arm->follow(planned());
  fate.join();
  EXPECT_EQ(moved.status, Status::kStopped);
  EXPECT_THAT(moved.reason, HasSubstr("protective stop"));
  EXPECT_THROW(cell.arm->rearm(), DeviceError);
  EXPECT_FALSE(cell.arm->state().can_move);
}

/// Error of making an arm, or "" if it could be made.
std::string problem_of(const UrServerOptions& options) {
  try {
    const Loopback cell(options);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

TEST(UrArmOnController, FieldbusesThatOwnWhatOthersSetUp) {
  UrServerOptions options;
  options.faults.fieldbus_owns_outputs = true;
  Loopback profinet(options);
  EXPECT_EQ(profinet.arm->follow(planned(0.1)).status, Status::kDone)
      << "no output stands among the inputs of a motion";
  const auto tool_output = [](const UrVersion&) {
    return RtdeRecipe{{"actual_q"}, {}, {{"tool_digital_output_mask", "tool_digital_output"}}};
  };
  RtdeOptions once;
  once.in_use_attempts = 1;
  try {
    const RtdeClient writer({"127.0.0.1", profinet.server.ports().rtde}, tool_output, once);
    FAIL() << "another master owns the outputs";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("tool_digital_output"));
    EXPECT_THAT(error.what(), HasSubstr("PROFINET"));
  }
  options = {};
  options.version = "3.8.0.61336";  // registers 0..23 only
  options.faults.fieldbus_owns_lower_registers = true;
  EXPECT_THAT(problem_of(options), HasSubstr("input_int_register_0"));
}

TEST(UrArmOnController, AFieldbusThatStopsProgramsIsASafetyStop) {
  UrServerOptions options;
  options.faults.fieldbus_stops_programs = true;
  Loopback cell(options);
  const MotionResult moved = cell.arm->follow(planned(0.1));
  EXPECT_EQ(moved.status, Status::kStopped);
  EXPECT_THAT(moved.reason, HasSubstr("protective stop (safety 3, bits 0x404)"));
  EXPECT_EQ(cell.arm->follow(planned(0.1)).status, Status::kRefused) << "until a person has looked";
}

TEST(UrArmOnController, AnEmergencyStopIsEndedByPeople) {
  UrServerOptions options;
  options.faults.emergency_stop_at = 0.5;
  Loopback cell(options);
  MotionResult moved = cell.arm->follow(planned());
  EXPECT_EQ(moved.status, Status::kStopped);
  EXPECT_THAT(moved.reason, HasSubstr("emergency stop of the robot"));
  EXPECT_THROW(cell.arm->rearm(), DeviceError);
  // The button is pulled out, the arm switched on, the brakes released; only then, and re-armed, it moves.
  TcpStream dashboard = TcpStream::connect({"127.0.0.1", cell.server.ports().dashboard}, Deadline::in(5));
  EXPECT_TRUE(dashboard.write_all("restart safety\npower on\nbrake release\n", Deadline::in(5)));
  const Deadline limit = Deadline::in(20);
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    moved = cell.arm->follow(planned(0.1));
  } while (!limit.over() && moved.reason.find("re-armed") == std::string::npos);
  EXPECT_EQ(moved.status, Status::kRefused) << "powered, brakes released, but nobody has confirmed a check";
  EXPECT_THAT(moved.reason, HasSubstr("re-armed"));
  cell.arm->rearm();
  while (!limit.over() && !cell.arm->state().can_move)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  JointTrajectory on = planned(0.1);
  const Joints offset = cell.arm->state().q - on.q.front();
  for (Joints& q : on.q) q += offset;
  moved = cell.arm->follow(on);
  EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
}

TEST(UrArmOnController, ALinkFromBeforeRemoteControlIsMadeAnew) {
  UrServerOptions options;
  options.version = "5.12.2.1101534";
  options.faults.read_only_links = 1;
  Loopback cell(options);
  const MotionResult moved = cell.arm->follow(planned(0.1));
  EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
  options.faults.read_only_links = 1000;
  Loopback never(options);
  EXPECT_EQ(never.arm->follow(planned(0.1)).status, Status::kRefused);
}

TEST(UrArmOnController, ScriptsThatNeverStartAreReported) {
  UrServerOptions options;
  options.faults.scripts_never_start = true;
  Loopback cell(options);
  const MotionResult moved = cell.arm->follow(planned(0.1));
  EXPECT_EQ(moved.status, Status::kRefused);
  EXPECT_THAT(moved.reason, HasSubstr("did not start within 1 s"));
}

TEST(UrArmOnController, ClosedPortsAndPolyScopeXAreNamed) {
  UrServerOptions options;
  options.faults.no_rtde = true;
  EXPECT_THAT(problem_of(options), HasSubstr("security settings"));
  options = {};
  options.faults.no_script_ports = true;
  EXPECT_THAT(problem_of(options), HasSubstr("security settings"));
  options = {};
  options.version = "10.7.0.0";
  EXPECT_THAT(problem_of(options), HasSubstr("PolyScope X 10.7.0.0"));
}

/// Error of connecting with that checksum in the cell.
std::string problem_with_safety(const UrServerOptions& options, const std::string& wanted) {
  try {
    const Loopback cell(options, nullptr, wanted);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(UrArmOnController, MovesWithTheSafetyConfigurationOfItsCellAlone) {
  for (const char* version : {"3.15.8.106339", "5.11.0.108249"}) {
    UrServerOptions options;
    options.version = version;
    options.safety_checksum = "57F4285B";
    Loopback same(options, nullptr, "57F4285B");
    EXPECT_EQ(same.arm->safety_checksum(), 0x57F4285BU);
    const MotionResult moved = same.arm->follow(planned(0.1));
    EXPECT_EQ(moved.status, Status::kDone) << moved.reason;
    EXPECT_THAT(problem_with_safety(options, "57F4285C"),
                testing::AllOf(HasSubstr("57F4285B"), HasSubstr("57F4285C"), HasSubstr("on the pendant"),
                               HasSubstr("arm.safety_checksum")));
    options.safety_checksum.clear();
    EXPECT_THAT(
        problem_with_safety(options, "57F4285B"),
        testing::AllOf(HasSubstr("says no checksum"), HasSubstr("57F4285B"), HasSubstr("remove the line")));
    Loopback any(options);
    EXPECT_FALSE(any.arm->safety_checksum());
    EXPECT_EQ(any.arm->follow(planned(0.1)).status, Status::kDone) << "the cell names none";
  }
  EXPECT_THAT(problem_with_safety({}, "CCCC"), HasSubstr("eight hexadecimal digits"));
}

TEST(UrArmOnController, FaultsOfTheWire) {
  UrServerOptions options;
  options.faults.missing_fields = "tcp_offset,payload,payload_cog,safety_status";
  options.faults.fieldbus_owns_lower_registers = true;
  options.faults.message_before_reply = true;
  options.faults.refuse_protocol_2 = true;
  Loopback old(options);
  EXPECT_EQ(old.arm->follow(planned(0.1)).status, Status::kDone);
  EXPECT_EQ(old.arm->missing_outputs().size(), 4u);
  options = {};
  options.version = "5.11.0.108249";
  options.faults.local_mode = true;
  Loopback local(options);
  const MotionResult refused = local.arm->follow(planned(0.1));
  EXPECT_EQ(refused.status, Status::kRefused);
  EXPECT_THAT(refused.reason, HasSubstr("Remote"));
  options = {};
  options.faults.script_dies_after = 0.2;
  Loopback dying(options);
  const MotionResult died = dying.arm->follow(planned());
  EXPECT_EQ(died.status, Status::kStopped);
  EXPECT_THAT(died.reason, HasSubstr("line "));
}

TEST(UrArmOnController, ACutLinkEndsTheMotion) {
  Loopback cell;
  std::thread fate([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    cell.server.cut_rtde();
  });
  const MotionResult moved = cell.arm->follow(planned());
  fate.join();
  EXPECT_EQ(moved.status, Status::kLost) << moved.reason;
}

/// Pushes back after some readings, along -z of W (the flange is turned, so through the arm's own pose).
struct PushingSensor : ForceTorqueSensor {
  explicit PushingSensor(const RobotModel& model) : robot(model) {}
  [[nodiscard]] Wrench read() override {
    const double push = ++reads > begin + 60 ? pushes : 1.0;
    const Eigen::Matrix3d R_R_F = forward(robot, ScriptBench::start()).rotation();
    return {R_R_F.transpose() * Eigen::Vector3d(0, 0, push), Eigen::Vector3d::Zero(), 0.01 * reads};
  }
  void zero() override {}
  const RobotModel& robot;
  int reads = 0, begin = 0;
  double pushes = 9.0;
};

TEST(UrArmOnController, GuardedDescentFeelsTheSensor) {
  const RobotModel robot = read_robot("ur10");
  PushingSensor sensor(robot);
  Loopback cell({}, &sensor);
  GuardedMotion motion;
  motion.trajectory = planned(0.05);
  for (double& t : motion.trajectory.time) t *= 4;
  for (Joints& qd : motion.trajectory.qd) qd /= 4;
  const MotionResult moved = cell.arm->follow_guarded(motion);
  EXPECT_EQ(moved.status, Status::kContact) << moved.reason;
  EXPECT_NEAR(moved.force, 8.0, 0.2);
  sensor.begin = sensor.reads;
  sensor.pushes = 4.0;
  const Joints offset = cell.arm->state().q - motion.trajectory.q.front();
  for (Joints& q : motion.trajectory.q) q += offset;
  const MotionResult slid = cell.arm->follow_guarded(motion);
  EXPECT_EQ(slid.status, Status::kNoContact) << slid.reason;
  EXPECT_NEAR(slid.mean_force, 3.0, 0.2) << "of this motion, not the end of the one before";
}

}  // namespace
}  // namespace stonestack::emulators

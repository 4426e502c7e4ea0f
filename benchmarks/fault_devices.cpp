#include "fault_devices.hpp"

#include <fcntl.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "forked_runs.hpp"
#include "stacking/journal.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::bench {
namespace {

using nlohmann::json;

constexpr double kMaxRun = 1500.0;   // s of simulated time: more counts as a hang
constexpr long kMaxCalls = 100000;   // of devices, likewise
constexpr double kJump = 0.05;       // rad between the arm and the start of a motion
constexpr double kHeld = 0.10;       // m from the tool's tip to the middle of a stone that it may hold
constexpr double kFree = 0.030;      // m below a stone that must not be let go of
constexpr double kBeneath = 0.07;    // m, level: what is so near lies beneath
constexpr double kClaimed = 0.030;   // m between a stone and where the run says that it stands
constexpr double kSilence = 5.0;     // s
constexpr double kDelay = 0.5;       // s
constexpr double kHour = 3600.0;     // s
constexpr double kDriftRate = 0.1;   // N/s
constexpr double kPast = 0.16;       // m, level, from the tool's tip to a stone that the fingers are clear of
constexpr double kPastStep = 0.01;   // m
constexpr double kLow = 0.20;        // m: the fingers of a tip that is lower reach what lies on the table
constexpr double kDeadline = 900.0;  // s of a run's process: more is a hang
constexpr double kSleep = 60.0;      // s
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Stands for a run that does not end.
struct Endless : std::runtime_error {
  Endless() : std::runtime_error("the run does not end") {}
};

/// Time limit that is over when the fault strikes: an interrupt that can be taken back.
struct Switch : Clock {
  std::atomic<bool> over{false};
  [[nodiscard]] double now() const override { return over ? 2.0 : 0.0; }
};

/// Recursive mutex whose owner stays its owner in a copy of the process, where threads have other numbers.
class CopiedMutex {
 public:
  void lock() {
    if (owner_ != std::this_thread::get_id()) {
      mutex_.lock();
      owner_ = std::this_thread::get_id();
    }
    ++depth_;
  }
  void unlock() {
    if (--depth_ > 0) return;
    owner_ = std::thread::id();
    mutex_.unlock();
  }

 private:
  std::mutex mutex_;
  std::atomic<std::thread::id> owner_;
  int depth_ = 0;
};

/// One run: the world, the fault, and what the devices saw.
struct FaultRun {
  const FaultScene& scene;
  const Fault* fault = nullptr;  ///< null: none strikes
  FaultPhase wanted;
  /// Called at each phase, of a run that others branch off: the cell whose fault strikes here, or null.
  std::function<const FaultCell*(FaultPhase)> branch;
  SimulatedCell world;
  Cell inner;
  Switch interrupt;
  std::optional<TimeLimit> limit;
  mutable CopiedMutex mutex;
  FaultPhase phase = FaultPhase::kConnect;
  FaultOutcome outcome;
  bool struck = false, once_done = false, lowered = false, moving_alone = false, stop_asked = false;
  long calls = 0;
  std::string stop_seen;  ///< the arm's stop, as the run was told of it
  Truth at_look;
  std::optional<DepthFrame> last_frame;
  std::optional<Wrench> last_wrench;
  std::optional<double> frozen_time;
  double struck_at = 0.0, tared_at = 0.0;  // s
  double slept = 0.0;                      // s that the host's steady clock did not count
  std::string journal_path;                ///< of a run whose disk fills up
  Journal journal;

  FaultRun(const FaultScene& s, const Fault* f, FaultPhase p, const SimulationOptions& options)
      : scene(s),
        fault(f),
        wanted(p),
        world(s.catalogue.stones, first_stones(s.catalogue.stones.size()), s.robot, CellLayout{}, options),
        inner(world.cell()),
        at_look(world.truth()) {
    if (fault == nullptr || fault->name != "disk full") return;
    static std::atomic<int> count{0};
    journal_path = concat(std::filesystem::temp_directory_path().string(), "/stonestack-faults-", ::getpid(),
                          '-', ++count, ".jsonl");
    journal = Journal(journal_path);
  }
  ~FaultRun() { remove_journal(); }
  FaultRun(const FaultRun&) = delete;
  FaultRun& operator=(const FaultRun&) = delete;

  void remove_journal() const {
    std::error_code ignored;
    if (!journal_path.empty()) std::filesystem::remove(journal_path, ignored);
  }
  [[nodiscard]] bool is(const char* name) const { return struck && fault->name == name; }
  [[nodiscard]] bool once(const char* name) {
    if (!is(name) || once_done) return false;
    return once_done = true;
  }
  void broken(int invariant, const std::string& why) {
    std::string& text = outcome.broken[static_cast<std::size_t>(invariant - 1)];
    if (text.empty()) text = concat(kFaultPhases[static_cast<std::size_t>(phase)], ": ", why);
  }
  void enter(FaultPhase next) {
    if (next < phase) return;
    phase = next;
    if (struck) return;
    if (branch) {
      const FaultCell* cell = branch(phase);
      if (cell == nullptr) return;
      fault = cell->fault, wanted = cell->phase;
    }
    if (fault == nullptr || phase < wanted) return;
    struck = outcome.reached = true;
    struck_at = world.truth().time;
    strike();
  }
  void called() {
    if (++calls > kMaxCalls || inner.clock.now() > kMaxRun) throw Endless();
  }
  [[noreturn]] void fail(const char* device, const std::string& problem) {
    if (std::string(device) == "arm" && stop_seen.empty()) stop_seen = problem;
    throw DeviceError(device, problem, "look at the cell");
  }
  void command() {
    called();
    if (!stop_seen.empty()) broken(2, "commanded after: " + stop_seen);
    if (is("disk full") && journal.lines() > 0) broken(2, "commanded without a journal");
  }
  /// Link faults of one device.
  void link(const char* device) {
    called();
    const std::string base = device;
    if (once((base + " lost once").c_str())) fail(device, "connection lost");
    if (is((base + " lost for ever").c_str())) fail(device, "connection lost");
    if (is((base + " silent").c_str())) {
      world.wait(kSilence);
      fail(device, "does not answer");
    }
    if (once((base + " delayed").c_str())) world.wait(kDelay);
    if (once("asleep between motions")) sleep();
  }
  /// The host is suspended while the devices go on.
  void sleep() {
    world.wait(kSleep);
    slept = kSleep;
  }

  [[nodiscard]] Pose tool() const {
    return inner.layout.T_W_R * forward(scene.robot, inner.arm.state().q) * inner.layout.T_F_T;
  }
  [[nodiscard]] Eigen::Vector3d tip() const { return tool().translation(); }
  [[nodiscard]] Eigen::AlignedBox3d box(std::size_t k, const Pose& T_W_O) const {
    Eigen::AlignedBox3d b;
    for (const auto& v : scene.catalogue.stones[k].scan.vertices) b.extend(T_W_O * v.cast<double>());
    return b;
  }
  /// Stone between the fingers, and the clearance below it.
  [[nodiscard]] std::optional<std::pair<std::size_t, double>> held() const {
    const Truth truth = world.truth();
    const Eigen::Vector3d p = tip();
    if (!inner.gripper.state().object) return std::nullopt;
    for (std::size_t k = 0; k < scene.catalogue.stones.size(); ++k) {
      const Eigen::AlignedBox3d mine = box(k, truth.T_W_O[k]);
      if ((mine.center() - p).norm() > kHeld) continue;
      double below = 0.0;
      for (std::size_t j = 0; j < scene.catalogue.stones.size(); ++j) {
        if (j == k) continue;
        const Eigen::AlignedBox3d other = box(j, truth.T_W_O[j]);
        if ((other.center() - mine.center()).head<2>().norm() < kBeneath)
          below = std::max(below, other.max().z());
      }
      return std::pair(k, mine.min().z() - below);
    }
    return std::nullopt;
  }
  /// Stone that the arm holds, else one at the site, else the first.
  [[nodiscard]] std::size_t victim() const {
    if (const auto holding = held()) return holding->first;
    const Truth truth = world.truth();
    for (std::size_t k = scene.catalogue.stones.size(); k-- > 0;)
      if ((truth.T_W_O[k].translation().head<2>() - inner.layout.site).norm() < 0.1) return k;
    return 0;
  }
  void move(std::size_t k, Pose T_W_O, bool to_table) {
    if (to_table) T_W_O.translation().z() -= box(k, T_W_O).min().z() - 0.001;
    world.place(StoneIndex(static_cast<int>(k)), T_W_O);
  }
  void shift(const Eigen::Vector3d& by, bool to_table) {
    const std::size_t k = victim();
    move(k, Eigen::Translation3d(by) * world.truth().T_W_O[k], to_table);
  }
  /// To where it lies on the table, or further that way, past the fingers: no stone can lie in them.
  void throw_over(const Eigen::Vector3d& by) {
    const std::size_t k = victim();
    const Eigen::Vector3d p = tip(), on = kPastStep * by.normalized();
    Pose T_W_O = Eigen::Translation3d(by) * world.truth().T_W_O[k];
    while (p.z() < kLow && (box(k, T_W_O).center() - p).head<2>().norm() < kPast) T_W_O.translation() += on;
    move(k, T_W_O, true);
  }
  /// Along the pads of the fingers about it, which no stone can pass; a stone that lies elsewhere along x.
  void slip(double by, bool to_table) {
    const std::size_t k = victim();
    const Pose T_W_T = tool();
    const bool in_fingers = (box(k, world.truth().T_W_O[k]).center() - T_W_T.translation()).norm() < kHeld;
    shift(in_fingers ? by * T_W_T.linear().col(1) : Eigen::Vector3d(by, 0, 0), to_table);
  }
  void strike() {
    const std::string& n = fault->name;
    const bool holding = held().has_value();
    if (n == "sudden loss" && holding) shift({0, 0, 0}, true);
    if (n == "slow slip" && holding) shift({0, 0, -0.010}, false);
    if (n == "opens by itself") (void)inner.gripper.move(0.155, 0.05, 60.0);
    if (n == "stone slips 5 mm") slip(0.005, false);
    if (n == "stone slips 20 mm") slip(0.020, !holding);
    if (n == "stone gone") shift({-3.0, 0, 0}, true);
    if (n == "tower falls") throw_over({0.0, -0.15, 0});
    if (n == "stone moved") throw_over({0.04, 0.02, 0});
    if (n == "interrupt") {
      limit.emplace(1.0, interrupt);
      interrupt.over = true;
    }
    if (n == "disk full") journal = Journal("/dev/full");
    if (n == "nobody reads the output") {  // of this process, which is a copy for this cell
      int ends[2];
      require(::pipe2(ends, O_CLOEXEC) == 0, "no pipe: ", std::strerror(errno));
      ::close(ends[0]);
      for (const int output : {STDOUT_FILENO, STDERR_FILENO})
        require(::dup2(ends[1], output) == output, "no pipe for the output: ", std::strerror(errno));
      ::close(ends[1]);
      set_log_level(LogLevel::kDebug);
    }
  }
  [[nodiscard]] std::string robot_stop() const {
    for (const char* name :
         {"protective stop", "safeguard stop", "emergency stop", "program stopped", "local mode"})
      if (is(name)) return name;
    return {};
  }
};

/// The first half of a motion, slowly and with an end at rest, so that the arm takes it.
JointTrajectory half_of(const JointTrajectory& whole) {
  constexpr double kShare = 0.2, kBrake = 1.0, kKnots = 0.02;  // of the speed; s; s
  const double half = 0.5 * whole.duration(), steady = half / kShare - 0.5 * kBrake;
  if (steady < 0) return whole;
  const int last = static_cast<int>(std::ceil((steady + kBrake) / kKnots));
  JointTrajectory slow;
  for (int k = 0; k <= last; ++k) {
    const double t = (steady + kBrake) * k / last, left = std::min(kBrake, steady + kBrake - t);
    const double share = kShare * left / kBrake;
    const JointState state = sample(whole, t < steady ? kShare * t : half - 0.5 * share * left);
    slow.time.push_back(t);
    slow.q.push_back(state.q);
    slow.qd.push_back(share * state.qd);
  }
  slow.q.front() = whole.q.front();
  slow.qd.back().setZero();
  return slow;
}

struct FaultyArm : Arm {
  FaultRun& run;
  explicit FaultyArm(FaultRun& r) : run(r) {}
  ArmState state() override {
    const std::scoped_lock lock(run.mutex);
    run.link("arm");
    ArmState s = run.inner.arm.state();
    if (run.phase == FaultPhase::kConnect) run.enter(FaultPhase::kStartPose);
    if (run.is("q not a number")) s.q[2] = kNan;
    if (run.is("q infinite")) s.q[2] = kInf;
    if (run.is("q 1e30")) s.q[2] = 1e30;
    if (run.is("q jumps")) s.q[1] += 0.5;
    if (run.is("time stamp frozen")) {
      if (!run.frozen_time) run.frozen_time = s.device_time;
      s.device_time = *run.frozen_time;
      s.host_time = *run.frozen_time;
    }
    s.host_time -= run.slept;
    if (const std::string stop = run.robot_stop(); !stop.empty()) {
      s.can_move = false;
      s.stop_reason = stop;
    }
    return s;
  }
  void check(const JointTrajectory& t) {
    const Joints q = run.inner.arm.state().q;
    if (!t.q.empty() && !((t.q.front() - q).cwiseAbs().maxCoeff() <= kJump))
      run.broken(3, concat("a motion starts ", (t.q.front() - q).cwiseAbs().maxCoeff(), " rad from the arm"));
    for (const Joints& knot : t.q)
      if (!knot.allFinite() || ((knot - run.scene.robot.upper).array() > 1e-6).any() ||
          ((run.scene.robot.lower - knot).array() > 1e-6).any())
        run.broken(6, "a joint value outside the limits");
  }
  MotionResult told(MotionResult r) {
    using Status = MotionResult::Status;
    if ((r.status == Status::kStopped || r.status == Status::kLost) && run.stop_seen.empty())
      run.stop_seen = r.reason;
    return r;
  }
  /// Motion under faults of robot and link; empty: none strikes.
  std::optional<MotionResult> faulty(const JointTrajectory& t) {
    using Status = MotionResult::Status;
    check(t);
    run.command();
    if (run.once("asleep in a motion")) {
      const MotionResult r = run.inner.arm.follow(half_of(t));  // the watchdog of its program stops the arm
      run.sleep();
      return told({Status::kStopped, r.q, 0.0, "the program was killed: by the heartbeat watchdog"});
    }
    if (run.is("another run")) {
      const Joints q = run.inner.arm.state().q;
      if (!run.stop_seen.empty()) return told({Status::kRefused, q, 0.0, "another client's program runs"});
      (void)run.inner.arm.follow(t);  // the other moves it on
      return told({Status::kStopped, q, 0.0, "the program was killed: by another client"});
    }
    try {
      run.link("arm");
    } catch (const DeviceError&) {
      run.moving_alone = true;  // the controller may have got the command
      throw;
    }
    if (run.is("motion lost")) {
      const MotionResult r = run.inner.arm.follow(half_of(t));
      run.moving_alone = true;
      return told({Status::kLost, r.q, 0.0, "connection lost in the motion"});
    }
    if (run.is("local mode")) return told({Status::kRefused, run.inner.arm.state().q, 0.0, "local mode"});
    if (const std::string stop = run.robot_stop(); !stop.empty()) {
      if (run.once_done) return told({Status::kRefused, run.inner.arm.state().q, 0.0, stop});
      run.once_done = true;
      const MotionResult r = run.inner.arm.follow(half_of(t));
      return told({Status::kStopped, r.q, 0.0, stop});
    }
    if (run.once("stops without notice")) return told(run.inner.arm.follow(half_of(t)));
    return std::nullopt;
  }
  MotionResult follow(const JointTrajectory& t) override { return move(t, false); }
  MotionResult carry(const JointTrajectory& t) override { return move(t, true); }
  MotionResult move(const JointTrajectory& t, bool carries) {
    const std::scoped_lock lock(run.mutex);
    if (run.phase == FaultPhase::kClose)
      run.enter(FaultPhase::kLift);
    else if (run.phase == FaultPhase::kLift)
      run.enter(FaultPhase::kTransfer);
    else if (run.phase == FaultPhase::kRelease)
      run.enter(FaultPhase::kRetreat);
    else if (run.phase == FaultPhase::kRetreat)
      run.enter(FaultPhase::kVerify);
    if (auto r = faulty(t)) return *r;
    return told(carries ? run.inner.arm.carry(t) : run.inner.arm.follow(t));
  }
  MotionResult follow_guarded(const GuardedMotion& m) override {
    const std::scoped_lock lock(run.mutex);
    if (run.phase == FaultPhase::kLift || run.phase == FaultPhase::kTransfer)
      run.enter(FaultPhase::kPrePlace);
    else if (run.phase == FaultPhase::kPrePlace)
      run.enter(FaultPhase::kDescent);
    if (auto r = faulty(m.trajectory)) return *r;
    const bool blind = run.is("stuck") || run.is("zero") || run.is("saturated");
    if (run.is("force not a number")) run.fail("force sensor", "a reading is not finite");  // as its driver
    if (!blind) return told(run.inner.arm.follow_guarded(m));
    MotionResult r = run.inner.arm.follow(m.trajectory);
    if (r.status == MotionResult::Status::kDone) r.status = MotionResult::Status::kNoContact;
    return told(r);
  }
  void stop() override {
    const std::scoped_lock lock(run.mutex);
    run.stop_asked = true;
    if (run.is("arm lost for ever") || run.is("arm silent"))
      throw DeviceError("arm", "connection lost", "look");
    run.inner.arm.stop();
  }
  void set_payload(double mass, const Eigen::Vector3d& p_F) override {
    const std::scoped_lock lock(run.mutex);
    run.link("arm");
    run.inner.arm.set_payload(mass, p_F);
  }
};

struct FaultyGripper : Gripper {
  FaultRun& run;
  explicit FaultyGripper(FaultRun& r) : run(r) {}
  GripperState told(GripperState s) const {
    if (run.is("holds without a stone")) s.object = true;
    if (run.is("opening not a number")) s.opening = kNan;
    return s;
  }
  GripperState state() override {
    const std::scoped_lock lock(run.mutex);
    run.link("gripper");
    return told(run.inner.gripper.state());
  }
  GripperState move(double opening, double speed, double force) override {
    const std::scoped_lock lock(run.mutex);
    if (opening <= 0.0 && run.phase == FaultPhase::kPreGrasp)
      run.enter(FaultPhase::kClose);
    else if (opening > 0.0 && run.phase >= FaultPhase::kPrePlace)
      run.enter(std::max(run.phase, FaultPhase::kRelease));
    run.command();
    const GripperState now = run.inner.gripper.state();
    if (const auto holding = run.held(); holding && opening > now.opening + 0.002 && holding->second > kFree)
      run.broken(5, concat("opens with a stone ", std::lround(1e3 * holding->second), " mm above anything"));
    run.link("gripper");
    if (run.is("not activated")) run.fail("gripper", "not activated");
    if (run.once("fault")) run.fail("gripper", "minor fault 0x0A");
    if (run.is("never reaches")) {
      run.world.wait(20.0);
      run.fail("gripper", "still moving after 20 s");
    }
    return told(run.inner.gripper.move(opening, speed, force));
  }
  void spread(double spacing) override {
    const std::scoped_lock lock(run.mutex);
    run.command();
    run.link("gripper");
    run.inner.gripper.spread(spacing);
  }
};

struct FaultySensor : ForceTorqueSensor {
  FaultRun& run;
  explicit FaultySensor(FaultRun& r) : run(r) {}
  Wrench read() override {
    const std::scoped_lock lock(run.mutex);
    run.link("sensor");
    Wrench w = run.inner.force_torque.read();
    if (!run.last_wrench || !run.is("stuck")) run.last_wrench = w;
    if (run.is("stuck")) w.force = run.last_wrench->force, w.torque = run.last_wrench->torque;
    if (run.is("zero")) w.force.setZero(), w.torque.setZero();
    if (run.is("drift")) w.force.z() += kDriftRate * (w.device_time - std::max(run.struck_at, run.tared_at));
    if (run.once("spike")) w.force.z() += 200.0;
    if (run.is("saturated")) w.force.setConstant(300.0);
    if (run.is("force not a number")) w.force.x() = kNan;
    if (run.is("force infinite")) w.force.x() = kInf;
    if (run.is("force 1e30")) w.force.x() = 1e30;
    w.host_time -= run.slept;
    return w;
  }
  void zero() override {
    const std::scoped_lock lock(run.mutex);
    run.link("sensor");
    run.inner.force_torque.zero();
    run.tared_at = run.world.truth().time;
  }
};

struct FaultyCamera : DepthCamera {
  FaultRun& run;
  explicit FaultyCamera(FaultRun& r) : run(r) {}
  DepthFrame capture() override {
    const std::scoped_lock lock(run.mutex);
    if (run.phase <= FaultPhase::kStartPose) run.enter(FaultPhase::kFirstLook);
    if (run.phase >= FaultPhase::kRelease) run.enter(FaultPhase::kVerify);
    run.link("camera");
    if (run.is("no frame")) {
      run.world.wait(2.0);
      run.fail("camera", "no frame within 2 s");
    }
    run.at_look = run.world.truth();
    DepthFrame f = run.inner.camera.capture();
    f.host_time -= run.slept;
    auto& z = f.image.z;
    const int width = f.image.camera.width, height = f.image.camera.height;
    const auto each = [&](const auto& change) {
      for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) change(u, v, z[static_cast<std::size_t>(v * width + u)]);
    };
    if (run.is("empty")) std::fill(z.begin(), z.end(), 0.0F);
    if (run.is("all not a number")) std::fill(z.begin(), z.end(), static_cast<float>(kNan));
    if (run.is("half empty")) each([&](int u, int, float& d) { d = u < width / 2 ? 0.0F : d; });
    if (run.is("depth x 1000")) each([](int, int, float& d) { d *= 1000.0F; });
    if (run.is("depth x 1.1")) each([](int, int, float& d) { d *= 1.1F; });
    if (run.is("table 10 mm higher")) each([](int, int, float& d) { d = d > 0 ? d - 0.01F : d; });
    if (run.is("obstacle in view"))
      each([&](int u, int v, float& d) { d = u > width / 3 && u < width / 2 && v < height / 2 ? 0.25F : d; });
    if (run.is("mirrored"))
      for (int v = 0; v < height; ++v) std::reverse(z.begin() + v * width, z.begin() + (v + 1) * width);
    if (run.is("camera moved"))
      for (int v = 0; v < height; ++v) {
        std::rotate(z.begin() + v * width, z.begin() + v * width + 40, z.begin() + (v + 1) * width);
        std::fill(z.begin() + (v + 1) * width - 40, z.begin() + (v + 1) * width, 0.0F);
      }
    if (run.is("frozen frame") && run.last_frame) return *run.last_frame;
    if (run.is("old frame") && run.last_frame) {
      f.image = run.last_frame->image;
      f.host_time = run.last_frame->host_time, f.device_time = run.last_frame->device_time;
    }
    run.last_frame = f;
    if (run.phase == FaultPhase::kFirstLook) run.enter(FaultPhase::kDetect);
    return f;
  }
};

struct FaultyClock : Clock {
  FaultRun& run;
  explicit FaultyClock(FaultRun& r) : run(r) {}
  [[nodiscard]] double now() const override {
    const double jump = run.is("clock an hour ahead") ? kHour : run.is("clock an hour back") ? -kHour : 0.0;
    return run.inner.clock.now() + jump - run.slept;
  }
};

SimulationOptions fault_cell(int seed) {
  SimulationOptions options = options_of_cell("ideal");
  options.seed = seed;
  return options;
}

BuildOptions fault_build(int seed) {
  BuildOptions options;
  options.measure_friction = false;
  options.refine_camera = false;
  options.search.horizon = 1;
  options.search.perturbations = 0;
  options.search.threads = 1;
  options.search.seed = options.motion.seed = seed;
  return options;
}

/// Stones of the claimed stack that do not stand where they are said to.
std::string false_claim(const FaultRun& run, const RunResult& result, const Truth& truth) {
  if (result.height != static_cast<int>(result.world.stack.size()))
    return concat("height ", result.height, " with ", result.world.stack.size(), " stones in the estimate");
  for (const auto& stone : result.world.stack) {
    const auto k = static_cast<std::size_t>(stone.stone.value());
    const Eigen::Vector3d& p_O_M = run.scene.catalogue.stones[k].mass.p_O_M;
    const double off = (truth.T_W_O[k] * p_O_M - stone.T_W_O_at_rest * p_O_M).norm();
    if (!(off <= kClaimed))
      return concat(run.scene.catalogue.stones[k].name, " is ", std::lround(1e3 * off),
                    " mm from where it is said");
  }
  return {};
}

}  // namespace

const std::vector<Fault>& known_faults() {
  static const std::vector<Fault> list = [] {
    std::vector<Fault> all;
    const auto add = [&](const char* family, std::initializer_list<const char*> names, bool fatal) {
      for (const char* name : names) all.push_back({family, name, fatal});
    };
    for (const char* device : {"arm", "gripper", "sensor"}) {
      const std::string base = device;
      all.push_back({"link", base + " lost once", true});
      all.push_back({"link", base + " lost for ever", true});
      all.push_back({"link", base + " silent", true});
      all.push_back({"link", base + " delayed", false});
    }
    add("link", {"motion lost"}, true);
    add("state",
        {"q not a number", "q infinite", "q 1e30", "q jumps", "time stamp frozen", "opening not a number"},
        true);
    add("state", {"force infinite", "force 1e30"}, true);
    add("robot", {"protective stop", "safeguard stop", "emergency stop", "program stopped", "local mode"},
        true);
    add("robot", {"stops without notice"}, true);
    add("gripper", {"not activated", "never reaches"}, true);
    add("gripper", {"fault", "holds without a stone", "sudden loss", "slow slip", "opens by itself"}, false);
    add("force", {"stuck", "zero", "saturated", "force not a number"}, true);
    add("force", {"drift", "spike"}, false);
    add("camera",
        {"camera lost once", "camera lost for ever", "camera silent", "no frame", "empty", "all not a number",
         "frozen frame", "old frame", "mirrored", "depth x 1000", "depth x 1.1", "camera moved"},
        true);
    add("camera", {"camera delayed", "half empty", "obstacle in view"}, false);
    add("world",
        {"stone slips 5 mm", "stone slips 20 mm", "tower falls", "stone moved", "table 10 mm higher"}, false);
    add("world", {"stone gone"}, true);
    add("host", {"interrupt", "disk full", "asleep in a motion", "another run"}, true);
    add("host",
        {"clock an hour ahead", "clock an hour back", "asleep between motions", "nobody reads the output"},
        false);
    return all;
  }();
  return list;
}

namespace {

/// The whole run and the verdict on it.
FaultOutcome finish(FaultRun& run) {
  FaultyArm arm(run);
  FaultyGripper gripper(run);
  FaultySensor sensor(run);
  FaultyCamera camera(run);
  FaultyClock clock(run);
  Cell cell{arm, gripper, sensor, camera, clock, run.inner.layout};
  BuildHooks hooks;
  hooks.listener = [&](const Event& event) {
    const std::scoped_lock lock(run.mutex);
    if (std::holds_alternative<Observed>(event) && run.phase == FaultPhase::kDetect)
      run.enter(FaultPhase::kPlan);
    if (std::holds_alternative<PlaceBegun>(event)) run.enter(FaultPhase::kPreGrasp);
  };
  if (!run.journal_path.empty()) hooks.journal = &run.journal;
  run.enter(FaultPhase::kConnect);
  std::optional<RunResult> result;
  try {
    result = build_tower(cell, run.scene.catalogue, run.scene.robot, fault_build(run.scene.seed), hooks);
  } catch (const Endless& endless) {
    run.broken(7, endless.what());
  } catch (const std::exception& error) {
    run.broken(7, concat("escaped: ", error.what()));
  }
  run.limit.reset();
  throw_if_interrupted();
  const auto struck_by = [&](const char* name) { return run.is(name) && run.wanted < FaultPhase::kVerify; };
  FaultOutcome& outcome = run.outcome;
  outcome.simulated = run.inner.clock.now();
  const Joints q = run.inner.arm.state().q;
  if ((run.moving_alone && !run.stop_asked) || !q.allFinite()) run.broken(1, "the arm was not told to stop");
  if (!result) return outcome;
  using End = RunResult::End;
  outcome.end = to_text(result->end);
  outcome.reason = result->ended;
  outcome.stopped = result->end == End::kStopped || result->end == End::kInterrupted;
  const std::size_t ends = all_of<RunEnded>(result->events).size();
  if (ends != 1 || result->ended.empty()) run.broken(4, concat(ends, " ends; reason: ", result->ended));
  if (struck_by("disk full") && !outcome.stopped)
    run.broken(4, "a run without a journal ended as " + outcome.end);
  if (struck_by("interrupt") && result->end != End::kInterrupted)
    run.broken(4, "an interrupted run ended as " + outcome.end);
  if (!run.stop_seen.empty() && !outcome.stopped && run.stop_seen.find("gripper") == std::string::npos)
    run.broken(4, concat("stopped by '", run.stop_seen, "', ended as ", outcome.end));
  if (std::string why = false_claim(run, *result, run.at_look); !why.empty()) run.broken(8, why);
  outcome.height = result->height;
  outcome.false_claim = false_claim(run, *result, run.world.truth());
  outcome.right =
      outcome.height == static_cast<int>(run.scene.catalogue.stones.size()) && outcome.false_claim.empty();
  return outcome;
}

std::string to_json(const FaultOutcome& outcome) {
  return json{{"reached", outcome.reached},
              {"right", outcome.right},
              {"stopped", outcome.stopped},
              {"broken", outcome.broken},
              {"end", outcome.end},
              {"reason", outcome.reason},
              {"height", outcome.height},
              {"false_claim", outcome.false_claim},
              {"simulated", outcome.simulated}}
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

FaultOutcome outcome_from(const ForkedRuns::Result& result) {
  FaultOutcome outcome;
  if (!result.problem.empty()) {
    outcome.reached = true;
    outcome.broken[6] = concat("the run's process: ", result.problem);
    return outcome;
  }
  const json j = json::parse(result.text);
  j.at("reached").get_to(outcome.reached), j.at("right").get_to(outcome.right);
  j.at("stopped").get_to(outcome.stopped), j.at("broken").get_to(outcome.broken);
  j.at("end").get_to(outcome.end), j.at("reason").get_to(outcome.reason);
  j.at("height").get_to(outcome.height), j.at("false_claim").get_to(outcome.false_claim);
  j.at("simulated").get_to(outcome.simulated);
  return outcome;
}

/// The journal of such a run is written from its start.
bool can_branch_off(const Fault& fault) {
  return fault.name != "disk full";
}

}  // namespace

void run_with_faults(const FaultScene& scene, std::vector<FaultCell>& cells, int at_once, bool from_start) {
  // Copies of the process have one thread each, and so has what is copied.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  {
    FaultRun without_fault(scene, nullptr, FaultPhase::kConnect, fault_cell(scene.seed));
    (void)finish(without_fault);  // grasps of the stones are found once, and kept for all copies
  }
  ForkedRuns runs(at_once, kDeadline);
  std::vector<bool> started(cells.size(), false), from_its_start(cells.size(), false);
  bool is_copy = false;
  const auto is_started = [&](std::size_t k) {
    started[k] = true;
    is_copy = runs.start(k);
    return is_copy;
  };
  // Of a copy this is the end.
  const auto run_to_end = [&](FaultRun& run) {
    std::string text;
    try {
      text = to_json(finish(run));
    } catch (...) {
      if (is_copy) ForkedRuns::fail();
      throw;
    }
    if (!is_copy) return;
    run.remove_journal();
    runs.finish(text);
  };
  if (!from_start) {
    FaultRun shared(scene, nullptr, FaultPhase::kConnect, fault_cell(scene.seed));
    shared.branch = [&](FaultPhase phase) -> const FaultCell* {
      if (is_copy) return nullptr;
      const bool possible = ForkedRuns::is_possible();
      for (std::size_t k = 0; k < cells.size(); ++k) {
        if (started[k] || from_its_start[k] || cells[k].phase > phase) continue;
        // Later it would strike too late.
        from_its_start[k] = !possible || !can_branch_off(*cells[k].fault);
        if (!from_its_start[k] && is_started(k)) return &cells[k];
      }
      return nullptr;
    };
    run_to_end(shared);
  }
  for (std::size_t k = 0; k < cells.size(); ++k)
    if (!started[k] && is_started(k)) {
      FaultRun run(scene, cells[k].fault, cells[k].phase, fault_cell(scene.seed));
      run_to_end(run);
    }
  for (const auto& [k, result] : runs.wait()) cells[k].outcome = outcome_from(result);
}

}  // namespace stonestack::bench

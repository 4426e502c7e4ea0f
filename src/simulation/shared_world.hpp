#pragma once
#include <array>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "simulation/simulated_devices.hpp"

namespace stonestack::simulation {

/// Where fingers are (GripperPose).
struct FingerPlaces {
  std::array<double, kFingers> finger{};
  double narrowed = 0.0;
};
/// Next places of the fingers, `seconds` from now; called once a tick with the world locked. It must not call
/// back into the SharedWorld.
using FingerDrive = std::function<FingerPlaces(const TrueWorld& world, double seconds)>;

/// One true world for several simulated devices, each with a thread of its own. One of them lets time pass:
/// the arm's controller with `move_arm`, or, when no arm is simulated, the loop that `start` runs. The others
/// read between two ticks (`lock`) and wait for simulated time (`wait_until`).
///
/// Time passes in ticks of at most 2 ms: at each the fingers follow the attached drive, and the
/// gripper goes straight to where the arm wants it.
class SharedWorld {
 public:
  /// None of these is owned; all must outlive this.
  SharedWorld(TrueWorld& world, const TrueMounting& mounting, const RobotModel& robot,
              const std::vector<Stone>& stones, const SimulationOptions& options);
  ~SharedWorld();

  /// The world while no time passes. Hold it briefly: the arm's control loop waits meanwhile.
  struct Access {
    std::unique_lock<std::mutex> lock;
    TrueWorld& world;
  };
  [[nodiscard]] Access lock();

  /// Moves the tool to T_W_T within `seconds`; the fingers follow their drive. Returns what stopped the
  /// gripper, if something did.
  Progress move_arm(const Pose& T_W_T, double seconds);
  /// Lets `seconds` pass with the arm where it is.
  Progress pass(double seconds);
  /// Sets or, with an empty function, removes what moves the fingers.
  void drive_fingers(FingerDrive drive);

  /// Simulated time, s.
  [[nodiscard]] double time() const;
  /// Blocks until simulated time is at least `time`; false after `host_seconds` without that.
  [[nodiscard]] bool wait_until(double time, double host_seconds);

  /// Lets time pass by itself, `speed` times faster than the clock on the wall, until `stop`. For cells
  /// without a simulated arm. Throws InvalidArgument for a speed that is not positive.
  void start(double speed);
  void stop();

  /// Constant part of the world: read without lock.
  [[nodiscard]] const TrueMounting& mounting() const { return mounting_; }
  [[nodiscard]] const RobotModel& robot() const { return robot_; }
  [[nodiscard]] const std::vector<Stone>& stones() const { return *stones_; }
  [[nodiscard]] const SimulationOptions& options() const { return options_; }

 private:
  Progress advance(const Pose& T_W_T, double seconds);
  void pass_time(double speed);

  TrueWorld* world_;
  TrueMounting mounting_;
  RobotModel robot_;
  const std::vector<Stone>* stones_;
  SimulationOptions options_;
  FingerDrive drive_;
  mutable std::mutex mutex_;
  std::condition_variable time_passed_;
  std::thread loop_;
  bool stopping_ = false;
};

}  // namespace stonestack::simulation

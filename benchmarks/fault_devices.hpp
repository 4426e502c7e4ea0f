#pragma once
#include <array>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stone/catalogue.hpp"

/// Devices of the simulated cell that do as they are told until one fault strikes, and the verdict on the
/// run.
namespace stonestack::bench {

/// Parts of a run at which a fault can strike, in order.
enum class FaultPhase {
  kConnect,
  kStartPose,
  kFirstLook,
  kDetect,
  kPlan,
  kPreGrasp,
  kClose,
  kLift,
  kTransfer,
  kPrePlace,
  kDescent,
  kRelease,
  kRetreat,
  kVerify
};
inline constexpr std::array kFaultPhases{"connect",   "start-pose", "first-look", "detect",   "plan",
                                         "pre-grasp", "close",      "lift",       "transfer", "pre-place",
                                         "descent",   "release",    "retreat",    "verify"};

/// A fault of one class.
struct Fault {
  std::string family;  ///< class: link, state, robot, gripper, force, camera, world or host
  std::string name;    ///< name within the class
  bool fatal = false;  ///< true where no run can be expected to go on
};
[[nodiscard]] const std::vector<Fault>& known_faults();

/// Stones and robot of every run.
struct FaultScene {
  Catalogue catalogue;
  RobotModel robot;
  int seed = 1;
};

/// Verdict on one run.
struct FaultOutcome {
  bool reached = false;                 ///< true if the phase came before the run's end
  bool right = false;                   ///< all stones stand, and the run reports that
  bool stopped = false;                 ///< the run ended as stopped or interrupted
  std::array<std::string, 8> broken{};  ///< for each invariant why it is broken; empty: kept
  std::string end, reason;              ///< end that the run reports
  int height = 0;                       ///< stones that the run reports to stand
  std::string false_claim;              ///< what does not stand as reported once the run has ended; or empty
  double simulated = 0.0;               ///< [s]
  [[nodiscard]] int count() const {
    int n = 0;
    for (const std::string& why : broken) n += why.empty() ? 0 : 1;
    return n;
  }
};
/// A fault and the phase at which it strikes.
struct FaultCell {
  const Fault* fault = nullptr;
  FaultPhase phase = FaultPhase::kConnect;
  FaultOutcome outcome;
};
/// Sets the outcomes of all cells. Until its fault strikes a run is like every other of its scene: one run
/// without a fault goes through the phases, and at each the process is copied for the faults that strike
/// there.
/// @param at_once   runs at a time, 0: one a core
/// @param from_start   each run is made from its start: the same outcomes, later
void run_with_faults(const FaultScene& scene, std::vector<FaultCell>& cells, int at_once, bool from_start);

}  // namespace stonestack::bench

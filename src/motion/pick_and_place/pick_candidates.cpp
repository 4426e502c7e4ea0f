#include "motion/pick_and_place/pick_candidates.hpp"

#include <algorithm>
#include <utility>

#include "kinematics/inverse.hpp"
#include "motion/timing.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr std::size_t kSolutionsAtPick = 4;   ///< nearest free inverse solutions looked at, each grasp
constexpr std::size_t kSolutionsAtPlace = 3;  ///< for each of those
constexpr std::size_t kPathsPerGrasp = 2;
constexpr double kScoreWorth = 4.0;  ///< time [s] of motion that a perfect grasp is worth over a useless one
constexpr double kSpacing = 0.003;   ///< between samples of the surface that pads press on [m]

// What a loose grasp costs. Measured with `stonestack-bench hold --every` (docs/measurements.md): of 149
// lifts that PadPress saw move less than 0.65 mm and press less than 4.3 mm deep 2 went wrong, of 156 beyond
// 0.75 mm or 4.3 mm 63.
constexpr double kFirm = 0.0006,
                 kLoose = 0.0012;  ///< distance [m] that the stone moves in the gripper under its weight
constexpr double kShallow = 0.0038, kDeep = 0.006;     ///< distance [m] into a pad: its rubber is 5 mm thick
constexpr double kTurned = 0.010, kFarTurned = 0.035;  ///< [rad]
constexpr double kSlipCost = 40.0;                     ///< what a stone that slips costs [s]
// In the simulated cell closing turns a stone by twice the prediction of PadPress (bench hold --every, 0.3
// to 2.4 deg), and it is set down turned by that.
constexpr double kStraight = 0.0035,
                 kTurnCost = 570.0;  ///< free angle [rad]; cost per angle [s/rad]: 10 s a degree
// A grasp that failed once may serve: the stone is seen anew, and a little elsewhere. Assumed, not measured.
constexpr double kFailsAgain = 0.5;
constexpr double kMaxLoad = 1.5;   ///< times the weight that a grasp should bear
constexpr std::size_t kParts = 3;  ///< of what is looked at of a grasp's firmness

/// 0 up to `low`, 1 from `high` on.
double ramp(double value, double low, double high) {
  return std::clamp((value - low) / (high - low), 0.0, 1.0);
}

/// Seconds at the joints' full speed, without acceleration: a lower bound.
double min_seconds(const Joints& a, const Joints& b, const Joints& velocity) {
  return (a - b).cwiseAbs().cwiseQuotient(velocity).maxCoeff();
}

}  // namespace

PickCandidates::PickCandidates(const PlanningScene& scene, const PickAndPlaceTask& task,
                               const MotionOptions& options, const GraspSet& set, const GraspCheck& check,
                               const ArmIsFree& arm_is_free)
    : task_(task), gripper_(scene.gripper), set_(set) {
  if (options.press_pads) surface_ = sample_surface(task.stone->scan, kSpacing);
  const Joints velocity = timing_limits(scene.robot, options).velocity;
  const Pose T_R_W = scene.T_W_R.inverse(), T_T_F = scene.T_F_T.inverse();
  for (const int index : check.usable) {
    throw_if_interrupted();
    const Grasp& grasp = set.grasps[static_cast<std::size_t>(index)];
    if (is_near_grasp(task.avoid, grasp.T_O_T) || is_near_grasp(task.no_pick, grasp.T_O_T)) continue;
    const double risk = is_near_grasp(task.failed_once, grasp.T_O_T) ? kSlipCost * kFailsAgain : 0.0;  // [s]
    std::vector<PickCandidate> own;
    const auto solutions = [&](const Pose& T_W_O, const Joints& seed, std::size_t max) {
      std::vector<Joints> free;
      for (const IkSolution& s : inverse(scene.robot, T_R_W * T_W_O * grasp.T_O_T * T_T_F, seed))
        if (free.size() < max && arm_is_free(index, s.q)) free.push_back(s.q);
      return free;
    };
    for (const Joints& pick : solutions(task.T_W_O_pick, task.q_start, kSolutionsAtPick)) {
      for (const Joints& place : solutions(task.T_W_O_place, pick, kSolutionsAtPlace)) {
        const double seconds = min_seconds(task.q_start, pick, velocity) + min_seconds(pick, place, velocity);
        const double price = kScoreWorth * (1.0 - grasp.score) + risk;
        own.push_back({index, pick, place, price, seconds + price});
      }
    }
    const auto cheaper = [](const PickCandidate& a, const PickCandidate& b) { return a.cost < b.cost; };
    std::stable_sort(own.begin(), own.end(), cheaper);
    own.resize(std::min(own.size(), kPathsPerGrasp));
    for (const PickCandidate& candidate : own) push({candidate});
  }
}

// The cheapest comes first; of two that cost the same, the better grasp.
struct PickCandidates::Later {
  bool operator()(const Entry& a, const Entry& b) const {
    return std::pair(a.cost(), a.bare.grasp) > std::pair(b.cost(), b.bare.grasp);
  }
};

void PickCandidates::push(Entry entry) {
  heap_.push_back(std::move(entry));
  std::push_heap(heap_.begin(), heap_.end(), Later());
}

void PickCandidates::add_part(const Grasp& grasp, Looseness& looseness) const {
  if (!looseness.pads) {
    const PadPress& pads = looseness.pads.emplace(surface_, task_.stone->mass, gripper_, grasp);
    double deepest = 0.0;
    for (int finger = 0; finger < 3; ++finger) deepest = std::max(deepest, pads.deepest(finger));
    if (!pads.holds()) looseness.risk = 1.0;
    looseness.pressed = 0.4 * ramp(deepest, kShallow, kDeep);
    looseness.turned = kTurnCost * std::max(0.0, pads.squeeze_turn() - kStraight);
  } else {
    const Pose& T_W_O = looseness.cost.size() == kParts ? task_.T_W_O_place : task_.T_W_O_pick;
    const Eigen::Vector3d n_T_down = -(T_W_O * grasp.T_O_T).linear().row(2).transpose();
    const PadPress::Load load = looseness.pads->bear(n_T_down, kMaxLoad);
    const double own = load.share < kMaxLoad ? 1.0
                                             : 0.6 * ramp(load.moved, kFirm, kLoose) +
                                                   0.2 * ramp(load.turned, kTurned, kFarTurned);
    looseness.risk = std::max(looseness.risk, own);
  }
  looseness.cost.push_back(kSlipCost * (looseness.risk + looseness.pressed) + looseness.turned);
}

double PickCandidates::looseness_cost(int grasp, std::size_t parts) {
  Looseness& looseness = looseness_[grasp];
  while (looseness.cost.size() <= parts) add_part(set_.grasps[static_cast<std::size_t>(grasp)], looseness);
  return looseness.cost[parts];
}

std::optional<PickCandidate> PickCandidates::next() {
  while (!heap_.empty()) {
    std::pop_heap(heap_.begin(), heap_.end(), Later());
    Entry first = std::move(heap_.back());
    heap_.pop_back();
    if (first.parts == kParts || surface_.empty()) {
      first.bare.price += first.looseness;
      first.bare.cost += first.looseness;
      return first.bare;
    }
    first.looseness = looseness_cost(first.bare.grasp, ++first.parts);
    push(std::move(first));
  }
  return std::nullopt;
}

}  // namespace stonestack::motion

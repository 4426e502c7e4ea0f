#pragma once
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/physics/stack.hpp"

#pragma GCC visibility push(default)

namespace stonestack::search {

/// Options of the search. `method`: "default" (gap field proposals, look-ahead) or "paper" (section 3 as
/// written).
struct SearchOptions {
  std::string method = "default";  ///< "default" or "paper"
  double friction = 0.1;           ///< what the planner assumes, paper §4.1
  /// Which of the highest towers is sought in default mode: "height", the one likeliest to stand; "firm", the
  /// one likeliest to outlast a shake of the table (physics::Shake).
  std::string objective = "height";

  // Eq. (2). Normalised by the references unless si_cost.
  double w1 = 0.179;     ///< weight of the support polygon's area
  double w2 = 0.472;     ///< weight of the kinetic energy
  double w3 = 0.094;     ///< weight of the distance
  double w4 = 0.255;     ///< weight of the normal
  bool si_cost = false;  ///< eq. (2) in SI, with the literal units

  // Paper mode.
  double theta_init = 0.785398;     ///< random initial rotation (companion paper, weak) [rad]
  double area_min = 1e-5;           ///< a contact pose on a smaller support polygon is none [m^2]
  int local_solutions = 5;          ///< x
  int restarts = 40;                ///< initial orientations tried for one local solution
  double initial_gap = 0.002;       ///< distance [m] along n_j between stack and stone at the start
  double contact_seconds = 1.0;     ///< simulated time [s] in which contact must come about
  int descent_rounds = 12;          ///< at most
  double descent_tolerance = 0.01;  ///< relative change of the cost that counts as converged

  // Default mode.
  double grid = 0.004;   ///< cell of the gap field [m]; refined at half of it
  int directions = 160;  ///< which side of a stone points down: directions over the sphere
  int yaws = 12;         ///< turns about the vertical, each direction
  int settled = 12;      ///< proposals for each tower that are let fall in simulation, at most
  int horizon = 4;       ///< levels that find_next_pose plans ahead; 1: greedy
  int beam = 4;          ///< towers that get their next stones, each level and round
  int rounds = 6;        ///< at most; the first that finishes a firm tower ends the search
  /// Angle between the world's up axis seen from the stone as it lies now and as it will lie [rad]; yaw is
  /// free. Little as in the paper, as one grasp serves both.
  double max_tilt = 1.0;

  // Verification, both modes.
  bool verify = true;              ///< false: what the search proposes, not settled nor judged
  double min_margin = 0.02;        ///< a stack below it is not proposed [g]
  double min_success = 0.5;        ///< a placement predicted to succeed less often is dropped
  int alternatives = 6;            ///< placements returned, at most
  double verdict_seconds = 10.0;   ///< simulated time [s], whole stack
  int perturbations = 8;           ///< k: displaced placements simulated for each verdict
  double perturbed_seconds = 2.0;  ///< simulated time [s], each of them
  // Measured in the cell `lab`, planned against measured poses of stones that hold: medians of 0.4 to 1.7 mm
  // an axis and 0.4 to 1.7 deg about it, more on higher levels, with long tails.
  double placement_sigma_translation = 0.002;  ///< one sigma along each axis [m]
  double placement_sigma_rotation = 0.03;      ///< one sigma about each axis [rad]
  /// One sigma of every centre of mass along each axis [m]: known to 3 mm, evenly in a ball, 1.3 mm an
  /// axis
  double com_sigma = 0.0015;

  int threads = 0;      ///< 0: all cores; the result does not depend on it
  double budget = 0.0;  ///< 0 [s]: none (deterministic)
  int seed = 1;         ///< seed of every random draw
  bool trace = false;   ///< keep every candidate in SearchResult::trace
};
[[nodiscard]] FieldList fields(SearchOptions& options);

/// A placement that a search compared with the one that it took, for reports.
struct Alternative {
  StoneIndex stone = kNoStone;          ///< index into `SearchProblem::shapes`
  Pose T_W_O = Pose::Identity();        ///< pose at which the stone rests
  double cost = 0.0;                    ///< eq. (2)
  std::map<std::string, double> terms;  ///< as those of a `Placement`
  double predicted_success = 0.0;       ///< share of perturbed placements that stand; 0: not tried
  double expected_height = 0.0;         ///< as that of a `Placement`
  std::string why_not;                  ///< why it was dropped; empty: it may do, and ranked lower
};

/// A stone and the pose where it should go.
struct Placement {
  StoneIndex stone = kNoStone;    ///< index into `SearchProblem::shapes`
  Pose T_W_O = Pose::Identity();  ///< pose at which the stone rests
  double cost = 0.0;              ///< eq. (2)
  std::map<std::string, double>
      terms;  ///< area, kinetic_energy, distance, normal: weighted terms of eq. (2); margin, ...
  double predicted_success = 0.0;  ///< share of perturbed placements that stand
  /// How the search means to go on after it (default mode), and how many stones, this one included, it
  /// expects to stand in the end, each as likely as it was judged. 0 if it was not judged.
  std::vector<PlacedStone> then;
  /// For each of `then` what the search compared with it, best first, at most five; empty where it did not.
  std::vector<std::vector<Alternative>> then_compared;
  double expected_height = 0.0;  ///< stones that are expected to stand in the end, by this route
  SupportPolygon support;        ///< support polygon of the stone
};

/// Stack, loose stones and site of a search.
struct SearchProblem {
  const ShapeList* shapes =
      nullptr;  ///< contact shapes of all stones, in the order of the catalogue; required
  /// Shapes that a stone may have instead (physics::make_possible_shapes): in the k-th displaced world the
  /// stone that is placed has that of the k-th list, modulo their number; what stands keeps `shapes`. May be
  /// null, and so may each shape.
  const std::vector<ShapeList>* possible_shapes = nullptr;
  Stack stack;                    ///< what stands (measured)
  bool stack_is_at_rest = false;  ///< it stands as it is at the friction of the options: not settled again
  /// Stones of the stack, from the table up, that stand as they were measured, though by their shapes, part
  /// of which are guesses, they cannot: they are held where they are, and what comes upon them must not
  /// tip them, by margins that are drawn (towers). Where any is held, the stack is not settled.
  int held = 0;
  std::vector<PlacedStone>
      available;  ///< loose stones, with their detected poses (paper: initial orientation)
  Eigen::Vector2d site = Eigen::Vector2d::Zero();  ///< where the first stone goes, W
  /// A route to the top that was found before, for example with less friction, bottom stone first: the
  /// default search continues it first and searches other routes only if that does not reach the top. May be
  /// empty.
  std::vector<PlacedStone> known_route;
  bool known_route_only = false;  ///< no other routes; nothing where it leads no higher
  /// May be empty. Can the arm bring that stone (index into `shapes`) from where it lies to that pose, when
  /// the stack has grown to `below` (what stands, then what the plan has put on it)? Called from one thread,
  /// best proposals first, before they are verified; what it refuses is counted and dropped.
  std::function<bool(StoneIndex stone, const Pose& T_W_O, const Stack& below)> reachable;
};

/// One candidate's path through the search, for `--trace`.
struct CandidateTrace {
  StoneIndex stone = kNoStone;          ///< index into `SearchProblem::shapes`
  std::vector<Pose> path_W_O;           ///< from the initial pose to contact or rest
  SupportPolygon support;               ///< support polygon at the end of the path
  double cost = 0.0;                    ///< eq. (2)
  std::map<std::string, double> terms;  ///< weighted terms of eq. (2), and figures beside them
  std::string outcome;                  ///< "kept", or why it was dropped
};

/// Result of a search for the next placement.
struct SearchResult {
  std::vector<Placement> best;        ///< best first, over all stones; several so that motion can refuse some
  std::vector<Alternative> others;    ///< other first placements, best first, at most five
  std::string reason;                 ///< when `best` is empty: why nothing was found
  long candidates = 0;                ///< poses evaluated
  int unreachable = 0;                ///< proposals that the arm could not bring about
  std::vector<CandidateTrace> trace;  ///< with SearchOptions::trace, in order
  double seconds = 0.0;               ///< duration [s]
};
/// The next placement (paper §3). Throws InvalidArgument for stones that cannot be (mass or friction not
/// positive, centre of mass outside the hull, not finite) and indices out of range; a stack that overlaps or
/// does not stand is refused with its reason. Ctrl-C and the budget end it with the best so far. `report`
/// receives progress from one thread.
[[nodiscard]] SearchResult find_next_pose(const SearchProblem& problem, const SearchOptions& options = {},
                                          const std::function<void(const std::string&)>& report = {});

/// Checks whether an earlier plan is still valid on the present stack. Puts the stones of `plan` at their
/// poses, bottom stone first, settled and judged; `best` is its first placement, or empty with the reason if
/// not all of it holds. Nothing is searched: this costs a small part of a search. Throws as find_next_pose
/// does.
[[nodiscard]] SearchResult follow_plan(const SearchProblem& problem, const std::vector<PlacedStone>& plan,
                                       const SearchOptions& options = {});

/// How many stones of a plan are expected to stand, of as much of it as holds; each counts as likely as all
/// below it and itself are to succeed. Cheaper than follow_plan, and throws as it does.
[[nodiscard]] double expected_height(const SearchProblem& problem, const std::vector<PlacedStone>& plan,
                                     const SearchOptions& options = {});

/// A tower on paper.
struct TowerPlan {
  std::vector<Placement> placements;  ///< from the bottom up
  std::string reason;                 ///< what stood in the way of more; empty: nothing
};
/// Plans a tower of `levels` more stones as if each placement succeeded, and returns the highest that it
/// found to stand. Throws as find_next_pose does; Ctrl-C and the budget end it with the best so far.
[[nodiscard]] TowerPlan plan_tower(SearchProblem problem, int levels, const SearchOptions& options = {},
                                   const std::function<void(const std::string&)>& report = {});

}  // namespace stonestack::search

#pragma GCC visibility pop

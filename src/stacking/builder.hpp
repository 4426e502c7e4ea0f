#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "stacking/believe.hpp"
#include "stacking/friction_belief.hpp"
#include "stacking/reach.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/motion/fit_for_hand.hpp"
#include "stonestack/motion/regrasp.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/execute.hpp"

/// Private to stacking/: one run of the loop, in parts. build_tower.cpp has the loop, builder_camera.cpp
/// what it learns about its camera, builder_ahead.cpp what it thinks of while the arm moves, builder_site.cpp
/// what stood there already, builder_reach.cpp what the arm can bring about, builder_target.cpp the search
/// for what comes next, builder_place.cpp what is done and how it is judged, builder_take_off.cpp the way
/// back: stones taken off, turned over, cleared away.
namespace stonestack::stacking {

/// What is to be done next, with the plan that does it.
struct Target {
  Placement placement;
  PickAndPlacePlan plan;
  PlanningScene scene;
};

/// One run: the belief, what it was made from, and the record.
class Builder {
 public:
  Builder(Cell& cell, const Catalogue& catalogue, const RobotModel& robot, const BuildOptions& options,
          const BuildHooks& hooks)
      : cell_(cell),
        catalogue_(catalogue),
        robot_(robot),
        options_(options),
        hooks_(hooks),
        shapes_(make_contact_shapes(catalogue.stones)),
        models_(catalogue.stones, options.detection),
        friction_(assumed_frictions(options)) {
    const GripperModel hand = hand_of(cell.layout);
    for (const Stone& stone : catalogue.stones) unfit_.push_back(unfit_for_hand(stone, hand, robot));
  }

  RunResult run() {
    look_around(false);
    if (belief_.loose.empty() && belief_.stack.empty() && site_ != SiteView::kTaken)
      return end(RunResult::End::kNothingSeen, "no stone was seen in the field");
    if (const std::string fault = fault_of_site(); !fault.empty()) return end(RunResult::End::kNoPose, fault);
    if (const std::string unfit = unfit_stones(); !unfit.empty())
      report("left out, for hand or arm cannot hold them: " + unfit);
    while (true) {
      throw_if_interrupted();
      if (clear_the_foot()) continue;
      if (high_enough()) break;
      const auto target = find_target();
      if (!target && (take_off() || dare_failed_grasps())) continue;
      if (!target || !place(*target)) break;
    }
    return std::move(result_);
  }

  /// An arm that does not answer any more is part of why.
  [[nodiscard]] RunResult stopped(RunResult::End how, std::string why) {
    try {
      cell_.arm.stop();
    } catch (const Error& problem) {
      why += concat("; the arm did not confirm a stop: ", problem.what());
    }
    return end(how, why);
  }

 private:
  /// How stones may be brought to their places: as they lie, or laid down another way before.
  enum class Ways { kInOneGo, kTurningToo };

  [[nodiscard]] RunResult end(RunResult::End how, const std::string& why) {
    result_.end = how;
    result_.ended = why;
    update_height();
    return std::move(result_);
  }

  void report(const std::string& line) const {
    if (hooks_.report) hooks_.report(line);
  }
  void record(const std::string& kind, const std::string& json) const {
    if (hooks_.journal != nullptr) hooks_.journal->record(kind, json);
  }
  [[nodiscard]] const std::string& name(int stone) const {
    return catalogue_.stones[static_cast<std::size_t>(stone)].name;
  }

  /// Stones of the stack up to the first that a loose stone touches: what leans on a tower makes it none.
  void update_height() {
    const auto stray = stray_at_stack(shapes_, belief_);
    result_.height = static_cast<int>(stray ? stray->level + 1 : belief_.stack.size());
    result_.belief = belief_;
  }

  [[nodiscard]] bool high_enough() {
    update_height();
    if (belief_.loose.empty()) {
      result_.end = RunResult::End::kAllPlaced;
      result_.ended = "all stones that are seen are placed";
      for (const int stone : gone_) result_.ended += concat("; ", name(stone), " is out of sight");
      return true;
    }
    if (height_is_reached(belief_)) {
      result_.end = RunResult::End::kHeightReached;
      result_.ended = concat("the tower has the ", options_.most_stones, " stones that were asked for");
      return true;
    }
    return false;
  }

  [[nodiscard]] bool height_is_reached(const Belief& belief) const {
    return options_.most_stones > 0 && static_cast<int>(belief.stack.size()) >= options_.most_stones;
  }

  /// Eq. (1) for every stone that can be seen: first the site, when something was built there, and the field,
  /// then where it was and beside the site if a stone is missing. `as_planned`: a stone has just been let go
  /// of where it should be, and the tower is searched on while the arm goes on to the field.
  void look_around(bool as_planned);
  /// Searches by what one look at the tower shows, and what was known of the field before.
  void search_on_tower(const Look& of_site);
  /// Searches as if that were the belief already, and keeps what is found in `ahead_`.
  void search_ahead(const Belief& belief);
  /// What was found ahead stays if the belief is now as it was thought to be; the tower then counts as seen
  /// by the look that was searched on.
  void keep_ahead();
  /// The loose stones that the hand gets hold of where they lie.
  [[nodiscard]] std::vector<int> held_stones() const;
  /// What was found ahead, or a search.
  [[nodiscard]] SearchResult search();
  /// What stands at the site by what was seen, from the table up.
  [[nodiscard]] std::vector<PlacedStone> standing(const std::vector<Sighting>& sightings) const;
  /// Tells, once a stone, of stones of which detection is not sure which they are or how they lie.
  void report_doubtful(const std::vector<Sighting>& sightings);
  /// Stones near where they were expected are taken to be there (`run.measure_placed` off).
  void believe_the_plan(std::vector<PlacedStone>& stack, const std::vector<PlacedStone>& expected) const;
  /// Tells of stones of the stack that are no longer where they were.
  void report_moved(const std::vector<PlacedStone>& expected) const;
  /// What the arm must stay clear of on its way to a look, hand empty.
  [[nodiscard]] PlanningScene scene_of_look() const;
  /// Where the hand stands too near to something to go anywhere: backs away from it, until it touches. Throws
  /// DeviceError when it does, or when the arm stops.
  void step_clear(const PlanningScene& scene);
  [[nodiscard]] Look look_at(const Eigen::Vector3d& p_W_target, bool all_unknown);
  /// `all_unknown`: at the beginning, when stones may lie or stand anywhere.
  [[nodiscard]] Look look_from(const std::vector<Pose>& T_W_C, bool all_unknown);
  /// Nothing if no pose can be reached; the other throws DeviceError then.
  [[nodiscard]] std::optional<JointTrajectory> find_way_to_look(const std::vector<Pose>& T_W_C,
                                                                bool all_unknown);
  [[nodiscard]] JointTrajectory way_to_look(const std::vector<Pose>& T_W_C, bool all_unknown);
  /// `meanwhile` is done while the arm is on its way, and may use anything but the arm and the camera; its
  /// seconds of detection and search count only as far as the arm has to wait for them.
  [[nodiscard]] Look look_along(const JointTrajectory& way, const std::function<void()>& meanwhile = {});
  /// Nothing if no pose for that look can be reached.
  [[nodiscard]] std::optional<Look> look_if_possible(const Eigen::Vector3d& p_W_target);
  /// Centre of mass, m, W.
  [[nodiscard]] Eigen::Vector3d com_of(const PlacedStone& stone) const;
  /// Stones that were seen before and are not now, but for those that were looked for in vain.
  [[nodiscard]] std::vector<int> out_of_sight() const;
  /// Looks at the field once more, half a turn about the optical axis away, and corrects where the camera is
  /// taken to sit, in the layout and in the looks; the second look is added to them. What they showed is
  /// returned as loose.
  [[nodiscard]] Belief refine_camera(std::vector<Look>& looks);
  /// Nobody knows what stands at the site when a run begins: if the looks do not show that nothing does, two
  /// more are added that show it from its sides, and `site_` tells what they show.
  void look_at_site(std::vector<Look>& looks);
  /// Why nothing can be built there: something unknown stood there already, or nobody knows; empty: it was
  /// free, or a tower of known stones.
  [[nodiscard]] std::string fault_of_site() const;
  /// What is to be placed next; lays a stone down another way on the way to it, if need be.
  [[nodiscard]] std::optional<Target> find_target();
  /// What the search is told: the stack, the loose stones, and as out of reach what the arm does not reach
  /// and what was given up.
  [[nodiscard]] SearchProblem make_problem(const Belief& belief, Ways ways) const;
  /// Those that failed and those that cannot pick the stone up where it lies, T_O_T.
  [[nodiscard]] std::vector<Pose> useless_grasps(int stone) const;
  void name_useless_grasps(PickAndPlaceTask* task, int stone) const;
  /// Of that belief; worked out once for `belief_`.
  [[nodiscard]] std::shared_ptr<Reach> reach_in(const Belief& belief) const;
  void forget_reach() {
    reach_.reset();
    possible_.clear();
  }
  /// "stone_156: of 8044 grasps 8044 hit the table at pick; ..." of loose stones that no grasp holds as they
  /// lie; empty: none is.
  [[nodiscard]] std::string not_held() const;
  [[nodiscard]] bool fits_hand(int stone) const;
  /// "stone_150 (3.16 kg, the fingers carry 2.5 kg), ..." of the loose stones; empty: none is.
  [[nodiscard]] std::string unfit_stones() const;
  /// Forgets which grasps failed: better one of these once more than none. False if none did.
  [[nodiscard]] bool dare_failed_grasps();
  /// Nothing was found to fit on that stone when it lay nearly there, or no motion brings it there.
  [[nodiscard]] bool was_given_up(int stone, const Pose& T_W_O) const;
  [[nodiscard]] SearchResult search_by_friction();
  /// Rising, from search.friction to most_friction.
  [[nodiscard]] static std::vector<double> assumed_frictions(const BuildOptions& options);
  /// Which of them the stones may have, for what stands there stands; all, if with none of them it would.
  [[nodiscard]] const std::vector<bool>& possible() const;
  /// Of these, what a search begins with.
  [[nodiscard]] std::size_t first_level() const;
  /// How a search at one of them goes about it.
  [[nodiscard]] SearchOptions search_at(std::size_t level, Ways ways) const;
  /// Stones of a plan that are expected to stand, with each friction that is asked about; 0 for the others.
  [[nodiscard]] std::vector<double> expected_by_friction(const SearchProblem& problem,
                                                         const std::vector<PlacedStone>& plan,
                                                         const std::vector<bool>& asked) const;
  /// A stone that was let go of there, on those, did not stay: the frictions with which it should have are
  /// less likely than was thought.
  void learn_from_fall(const std::vector<PlacedStone>& below, const Placement& fallen);
  /// Stones that are expected to stand by a found placement and what is to follow it, over all possible
  /// frictions; `level` of them was assumed by the search that found it.
  [[nodiscard]] double outlook(const SearchProblem& problem, const Placement& found, std::size_t level) const;
  /// The mean over the frictions at which the stack can stand, by how likely each is.
  [[nodiscard]] double weighed(const std::vector<double>& expected) const;
  /// How the tower was meant to go on, moved with where its top really came to lie; the same as before if the
  /// stone was not picked; empty if something else happened.
  [[nodiscard]] std::vector<PlacedStone> rest_of_plan() const;
  /// That, if it still holds: at the friction it was found with, or at a higher one where the whole of it is
  /// still expected to stand.
  [[nodiscard]] std::optional<SearchResult> rest_that_holds(const SearchProblem& problem, Ways ways,
                                                            double levels);
  [[nodiscard]] std::optional<Target> plan(const Placement& placement, std::string* refusal);
  /// The approach to the grasp ends at what it meets.
  void feel_to_grasp(PickAndPlacePlan& plan, int stone) const;
  /// By how much placed stones were seen beside their targets so far, level: hand-eye and arm calibration err
  /// the same way each time, and the camera tells by how much.
  [[nodiscard]] Eigen::Vector3d placing_bias() const;
  /// False when the run is over.
  [[nodiscard]] bool place(const Target& target);
  void judge(PlacementRecord& record, const Placement& planned, ExecutionResult::Status done);
  /// When nothing fits on the stack: puts as many stones back into the field as leave the most to expect, if
  /// the search then finds a higher tower another way. False when it does not, or the arm cannot do it.
  [[nodiscard]] bool take_off();
  /// The belief when the top `count` stones lie in the field; empty when there is no room for them.
  [[nodiscard]] std::optional<Belief> without_top(std::size_t count) const;
  /// How many stones are expected to stand in the end if the tower goes on from `lower`; 0 where the search
  /// finds none higher than what stands.
  [[nodiscard]] double expected_another_way(const Belief& lower) const;
  /// Puts the top stone into the field, wherever the arm can: lifted straight up or, if that is given, along
  /// `n_W_lift` first (unit), out of what leans on it.
  [[nodiscard]] bool set_down_top(const std::optional<Eigen::Vector3d>& n_W_lift = std::nullopt);
  [[nodiscard]] bool set_down(const PlacedStone& top, const Pose& T_W_O_down,
                              const std::optional<Eigen::Vector3d>& n_W_lift, std::string* refusal);
  /// Takes a stone that fell against the tower back into the field: a tower on which a stone leans is not
  /// clean, and fingers have no room between the two. False if there is none, or nothing could be done.
  [[nodiscard]] bool clear_the_foot();
  [[nodiscard]] bool may_turn_over() const { return turned_over_ < options_.most_turned_over; }
  /// Takes the tower off down to the stone that another leans on, with that one: above it nothing counts, and
  /// without it the other lies free. False if that may not be or nothing could be done.
  [[nodiscard]] bool take_off_down_to(const Stray& stray);
  /// Lays one of the stones down in another pose of rest, so that it can be grasped anew and brought to its
  /// placement. False when no motion does that.
  [[nodiscard]] bool turn_over(const std::vector<Placement>& found);
  /// After a stone was laid down: if it is seen otherwise, that pose of rest is not tried with it again.
  void note_toppled(const PlacedStone& meant);
  [[nodiscard]] RegraspOptions regrasp_options(int stone) const;
  /// Carries out a plan that leaves a stone on the table, and looks.
  void lay_down(const PickAndPlacePlan& plan, const PlanningScene& scene, int stone, const Pose& T_W_O_down,
                PlacementRecord::Outcome outcome);

  Cell cell_;  ///< the caller's devices; the layout is corrected by what is seen
  const Catalogue& catalogue_;
  const RobotModel& robot_;
  const BuildOptions& options_;
  const BuildHooks& hooks_;
  ShapeList shapes_;
  DetectionModels models_;
  std::vector<std::string> unfit_;  ///< why the hand can hold a stone in no pose; empty: it can
  FrictionBelief friction_;
  Belief belief_;
  SiteView site_ = SiteView::kFree;             ///< when the run began
  mutable std::shared_ptr<Reach> reach_;        ///< of `belief_`, or empty
  mutable std::vector<bool> possible_;          ///< `possible()` for `belief_`, or empty
  std::string said_not_held_;                   ///< what `not_held` told last
  std::map<int, Eigen::Vector3d> seen_before_;  ///< m, W, centre of mass of each stone when it was seen last
  std::set<int> gone_;                          ///< of these, that were looked for beside the site in vain
  std::set<int> doubtful_;                      ///< that were said to be seen with little certainty
  RunResult result_;
  /// A search that was done before the belief was certain.
  struct Ahead {
    Belief belief;
    std::vector<int> held;  ///< `held_stones` of it
    SearchResult found;
    std::size_t level = 0;       ///< `last_level_` after it
    Ways ways = Ways::kInOneGo;  ///< `last_ways_` after it
  };
  std::optional<Ahead> ahead_;
  std::vector<Eigen::Vector3d> aimed_off_;  ///< m, the bias that each placement already made up for
  int failures_ = 0;                        ///< placements that did not hold
  int taken_off_ = 0, turned_over_ = 0, cleared_ = 0;
  Placement last_;                   ///< that was carried out last, with how the search meant to go on
  std::size_t last_below_ = 0;       ///< stones that stood before it
  std::size_t last_level_ = 0;       ///< of the assumed frictions, which its search had
  Ways last_ways_ = Ways::kInOneGo;  ///< what its search counted on
  std::map<int, std::vector<Pose>> failed_grasps_;       ///< T_O_T by stone
  std::map<int, std::vector<Eigen::Vector3d>> toppled_;  ///< ups, frame O, in which it did not stay
  std::map<int, std::vector<Pose>> no_pick_;  ///< the same, that do not lift it from where it lies now
  std::vector<PlacedStone> refused_;          ///< poses to which no motion was found, since the last look
  std::vector<PlacedStone> given_up_;         ///< tops of stacks on which nothing was found to fit
};

}  // namespace stonestack::stacking

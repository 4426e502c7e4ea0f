#pragma once
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "stacking/choose_action.hpp"
#include "stacking/model_field.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: the devices of a run, and what is done with them.
namespace stonestack::stacking {

/// Devices, models and options of a run, and who hears of it.
struct Workcell {
  Cell cell;  ///< the caller's devices; the layout is corrected by what is seen, unknown objects among it
  const Models& models;
  const DetectionModels& detection;
  const BuildOptions& options;
  StageSeconds& seconds;
  Listener emit;
  /// Adds a stone to `models` and `detection`; who listens to the run is told before any event names it.
  /// Empty: none is added.
  ModelledHook add_stone;
  std::vector<Obstacle> stated_obstacles = cell.layout.obstacles;  ///< those of the cell file
  std::vector<Eigen::Vector3d> unknown_surface_W = {};             ///< what was seen of unknown objects
};

/// Expected view of the world.
struct Expectation {
  std::vector<StoneEstimate> stack, loose;
  SiteStatus site = SiteStatus::kFree;
  FrictionEstimate friction;       ///< at whose frictions the stack is settled
  std::vector<StoneIndex> known;   ///< stones that were seen in this run
  std::set<StoneIndex> disproved;  ///< not looked for: another model takes their place, or they are no stones
  bool first = false;              ///< nothing was observed yet
  bool as_planned = false;         ///< a stone has just been released where it should be
  bool new_top = false;            ///< the top stone was not part of the stack before
  bool was_built = false;          ///< a stone was brought to the site, where something may lie now
  /// To which one more view is added from where the camera is, so that nothing moves; else null.
  std::shared_ptr<const Views> views;
};

/// The world as seen, and whether it is what was predicted while the arm moved.
struct Observation {
  WorldEstimate world;
  bool as_predicted = false;
};
/// Called with a prediction of the world, from part of the views, while the arm moves to the next view.
using WhileMoving = std::function<void(const WorldEstimate& predicted)>;

/// Eq. (1) for every stone that can be seen: first the site, when something was built there, and the field.
/// The first time the camera's mount is refined and the site examined. The stack is settled. Throws
/// DeviceError when no view can be reached.
[[nodiscard]] Observation observe(Workcell& workcell, const Expectation& expected,
                                  const WhileMoving& while_moving);

// Parts of it.

/// Scene for a route to a view, gripper empty.
[[nodiscard]] PlanningScene scene_of_view(const Workcell& workcell, const Arrangement& arrangement);
/// Views are taken as long as nobody knows what lies there (`all_unknown`), or with these stones in the
/// scene.
struct ViewScene {
  Arrangement arrangement;
  bool all_unknown = false;
};
/// Nothing if no pose can be reached; the other throws DeviceError then.
[[nodiscard]] std::optional<JointTrajectory> find_route(Workcell& workcell, const ViewScene& scene,
                                                        const std::vector<Pose>& T_W_C);
[[nodiscard]] JointTrajectory route_to(Workcell& workcell, const ViewScene& scene,
                                       const std::vector<Pose>& T_W_C);
/// Follows the route and takes a view at its end. `meanwhile` is done while the arm moves, and may use
/// anything but arm and camera; its seconds of detection and search count only as far as the arm has to wait
/// for them.
[[nodiscard]] CameraView view_along(Workcell& workcell, const JointTrajectory& route,
                                    const std::function<void()>& meanwhile = {});
/// Views the field once more, half a turn about the optical axis away, and corrects where the camera is taken
/// to sit, in the layout and in the views; the second view is added to them. Returns what they showed, as
/// loose. `while_moving` hears what the first view shows.
[[nodiscard]] Arrangement refine_camera(Workcell& workcell, const FrictionEstimate& friction, Views& views,
                                        const WhileMoving& while_moving);
/// Reports stones of which detection is not sure which they are or how they lie.
void report_uncertain(const Workcell& workcell, const std::vector<Sighting>& sightings);

}  // namespace stonestack::stacking

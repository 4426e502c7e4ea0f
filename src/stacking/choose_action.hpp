#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stacking/run_memory.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/event.hpp"

namespace stonestack::stacking {

/// Stones and robot, as known before anything is seen. Catalogue and robot must outlive it.
struct Models {
  const Catalogue* catalogue = nullptr;
  const RobotModel* robot = nullptr;
  ShapeList shapes;
  std::vector<std::string> unfit;  ///< why the gripper can hold a stone in no pose; empty: it can
  std::optional<WallTarget> wall;  ///< wall that is built; empty: a tower
  std::vector<ShapeList> possible_shapes =
      {};  ///< that stones may have which were modelled from views; empty: none was

  [[nodiscard]] const std::string& name(StoneIndex stone) const;
  [[nodiscard]] const Stone& stone(StoneIndex stone) const;
};
/// @param wall BuildOptions::wall
/// @throws InvalidArgument and FileError for a wall that cannot be read
[[nodiscard]] Models make_models(const Catalogue& catalogue, const RobotModel& robot,
                                 const CellLayout& layout, const std::string& wall = "");

/// Adds the stack as it rests at each friction: needed by `choose_action`, for a world that was read from a
/// file.
void add_resting_stacks(const Models& models, const BuildOptions& options, const FrictionEstimate& friction,
                        WorldEstimate& world);

/// A memory with which a run begins.
[[nodiscard]] RunMemory make_memory(const BuildOptions& options);

/// The next action, and why.
struct Decision {
  Action action;
  RunMemory memory;        ///< with what was found out: the result of the search, what was given up
  std::vector<Event> why;  ///< in order
};

/// Where a world comes from: all views, or a prediction from the first of them, which is often displaced by a
/// millimetre or two.
enum class Basis { kObserved, kPredicted };

/// Decides what the robot does next. Pure: asks no device and no clock, and the same world, memory and
/// options give the same decision. In this order: ends after a failure; searches for stones out of sight;
/// models anew what no model shows; goes on unstacking; models the top stone anew; clears the base; ends when
/// the height is reached; pushes a stone free; places or reorients a stone by the search
/// (src/stacking/choose_placement.hpp), or pushes one first where it leaves stones out; pushes where only
/// that helps; unstacks where nothing fits; retries grasps that failed twice; ends. `listener` hears events
/// as they happen.
/// @param basis predicted: where nothing is found the decision ends, without asking what could be taken off;
///     where a tower's first search finds nothing, none follows at other frictions, and there is no
///     `memory.search`
/// @throws Interrupted and InvalidArgument for a world without resting stacks.
[[nodiscard]] Decision choose_action(const WorldEstimate& world, const RunMemory& memory,
                                     const Models& models, const BuildOptions& options,
                                     const Listener& listener = {}, Basis basis = Basis::kObserved);

}  // namespace stonestack::stacking

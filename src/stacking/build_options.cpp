#include "stonestack/stacking/build_tower.hpp"

#include <algorithm>

#include "search/search_context.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/search/plan_wall.hpp"

namespace stonestack::stacking {

Field gripper_field(std::string& name) {
  return user(field("hand", name,
                    "gripper of the simulated cell: robotiq-3f, robotiq-2f-85, robotiq-2f-140, "
                    "robotiq-hand-e or a YAML; a cell file names its own"));
}

FieldList fields(BuildOptions& o) {
  return join(
      {nest("detection", fields(o.detection)), nest("search", fields(o.search)),
       nest("motion", fields(o.motion)),
       nest("gripper", {field("linkage", o.linkage,
                              "path of the finger tips that plans count on: parallel (flat jaws) or "
                              "three_finger (on the arc of its fingers)"),
                        gripper_field(o.gripper)}),
       nest("run",
            {user(field("max_stones", o.max_stones, {0, 100}, "",
                        "height at which the run ends; 0: all stones that are seen")),
             user(field("view_distance", o.view_distance, {0.3, 1.2}, "m",
                        "distance from the camera to the viewed point; SR300: 0.2 to 1.5 m")),
             field("max_friction", o.max_friction, {0, 2}, "",
                   "the search starts at search.friction and climbs to this while it finds no sure pose"),
             user(field("max_failures", o.max_failures, {1, 100}, "",
                        "placements that may fail before the run ends; the paper: 1")),
             field("refine_camera", o.refine_camera,
                   "true: the camera's mount is refined from two first views"),
             field("measure_placed", o.measure_placed,
                   "false: placed stones are taken to lie as planned, if they are seen near there"),
             field("measure_friction", o.measure_friction,
                   "true: the first stone is dragged over the table to measure the friction"),
             field("correct_aim", o.correct_aim,
                   "true: placements are corrected by the mean error of earlier ones"),
             user(field("max_reoriented", o.max_reoriented, {0, 100}, "",
                        "stones that may be reoriented because no grasp serves both ends, and pushed because "
                        "no finger gets beside them; the paper: 0")),
             user(field("max_unstacked", o.max_unstacked, {0, 100}, "",
                        "stones that may be unstacked to build the tower or wall otherwise; the paper: 0")),
             user(field("pick_attempts", o.pick_attempts, {1, 10}, "",
                        "tries to pick a stone that the gripper misses or drops")),
             user(field("wall", o.wall,
                        "wall that is built: stones a course (4+3+2+1), metres x courses (0.8x3), "
                        "bridge:METRES or a target "
                        "file; empty: a tower")),
             user(field("unseen", o.unseen,
                        "true: the arm's camera models the stones before it builds; no catalogue is known")),
             field("save_states", o.save_states,
                   "true: the state before each decision, for `decide`, and what the devices answer, for "
                   "`replay`, are written into the run's folder")})});
}

void check_options(const BuildOptions& options) {
  search::check_options(options.search);
  if (options.wall.empty()) return;
  static_cast<void>(read_wall_target(options.wall));
  require(options.search.method == "default", "a wall needs the default search, not ", options.search.method);
  require(options.search.objective == "height", "search objective ", options.search.objective,
          " is for towers, not for walls");
}

std::vector<double> assumed_frictions(const BuildOptions& options) {
  std::vector<double> list{options.search.friction};
  while (list.back() < options.max_friction)
    list.push_back(std::min(options.max_friction, list.back() + options.friction_step));
  return list;
}

}  // namespace stonestack::stacking

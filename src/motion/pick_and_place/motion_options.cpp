#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::motion {

FieldList fields(MotionOptions& o) {
  return {
      user(field("speed_scale", o.speed_scale, {0.01, 1}, "", "share of the joint velocity limits")),
      user(field("acceleration", o.acceleration, {0.05, 20}, "rad/s^2",
                 "of every joint; UR publishes no limit, 1.4 is its own default")),
      user(field("jerk", o.jerk, {0, 10000}, "rad/s^3",
                 "of every joint, at least 1: slower but smoother; 0: no limit")),
      user(field("tool_speed", o.tool_speed, {0.05, 10}, "m/s", "of the tool on transits at most")),
      user(field("near_speed", o.near_speed, {0.02, 10}, "m/s",
                 "of the tool at most where it is near a stone or another object")),
      field("near_distance", o.near_distance, {0, 1}, "m", "between tool and object that counts as near"),
      user(field("approach", o.approach, {0.01, 0.5}, "m", "length of the straight approach and retreat")),
      user(field("descent_speed", o.descent_speed, {0.0005, 0.05}, "m/s",
                 "of the guarded descent: slower sets down more softly")),
      field("descent_past", o.descent_past, {0, 0.1}, "m",
            "past the expected contact, where the guarded descent gives up"),
      user(field("transit_padding", o.transit_padding, {0, 0.1}, "m", "clearance on transits")),
      field("approach_padding", o.approach_padding, {0, 0.1}, "m", "clearance on straight approaches"),
      user(field("approach_speed", o.approach_speed, {0.005, 1}, "m/s",
                 "of the tool on straight approaches, lifts and retreats")),
      user(field("min_threshold", o.min_threshold, {0.5, 100}, "N",
                 "smallest force that counts as contact during the guarded descent")),
      field("early_threshold", o.early_threshold, {1, 100}, "N",
            "force that counts as contact while a stone is lowered towards the guarded descent"),
      field("force_noise", o.force_noise, {0, 10}, "N",
            "of the force sensor, one sigma; contact is at least six of these"),
      field("press_pads", o.press_pads, "true: grasps are ranked by how firmly the elastic pads hold, too"),
      field("planning_effort", o.planning_effort, {0.01, 600}, "",
            "work on a plan at most, counted in collision checks; 1 is about a second on one core"),
      field("seed", o.seed, {0, 2147483647}, "", "seed of the planner's random numbers")};
}

}  // namespace stonestack::motion

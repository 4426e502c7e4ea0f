#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack {

FieldList fields(MotionOptions& o) {
  return {field("speed_scale", o.speed_scale, {0.01, 1}, "", "ours"),
          field("acceleration", o.acceleration, {0.05, 20}, "rad/s^2", "facts/robot.md: not public, 1.4"),
          field("approach", o.approach, {0.01, 0.5}, "m", "facts/robot.md: 8 to 12 cm"),
          field("lift", o.lift, {0.01, 0.5}, "m", "ours"),
          field("descent_speed", o.descent_speed, {0.0005, 0.05}, "m/s", "facts/robot.md"),
          field("descent_length", o.descent_length, {0.001, 0.1}, "m", "facts/robot.md"),
          field("descent_past", o.descent_past, {0, 0.1}, "m", "facts/robot.md"),
          field("transit_padding", o.transit_padding, {0, 0.1}, "m", "facts/robot.md"),
          field("approach_padding", o.approach_padding, {0, 0.1}, "m", "facts/robot.md"),
          field("planning_seconds", o.planning_seconds, {0.01, 600}, "s", "ours"),
          field("seed", o.seed, {0, 2147483647}, "", "ours")};
}

}  // namespace stonestack

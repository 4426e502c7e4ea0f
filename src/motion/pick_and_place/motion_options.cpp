#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::motion {

FieldList fields(MotionOptions& o) {
  return {field("speed_scale", o.speed_scale, {0.01, 1}, "", "ours"),
          field("acceleration", o.acceleration, {0.05, 20}, "rad/s^2",
                "UR publishes none; 1.4 is its own default"),
          field("jerk", o.jerk, {0, 10000}, "rad/s^3", "ours: 0, no limit; at least 1"),
          field("tool_speed", o.tool_speed, {0.05, 10}, "m/s", "ours"),
          field("near_speed", o.near_speed, {0.02, 10}, "m/s",
                "measured: 0.25 within 10 cm costs 9.5 % of a placing, this 2.5 %"),
          field("near_distance", o.near_distance, {0, 1}, "m", "ours"),
          field("approach", o.approach, {0.01, 0.5}, "m", "ours: 8 to 12 cm is usual"),
          field("lift", o.lift, {0.01, 0.5}, "m", "ours"),
          field("descent_speed", o.descent_speed, {0.0005, 0.05}, "m/s", "ours: 5 mm/s; bench descent"),
          field("descent_length", o.descent_length, {0.001, 0.1}, "m", "ours: the last 20 mm"),
          field("descent_past", o.descent_past, {0, 0.1}, "m", "ours: 15 mm past the target"),
          field("descent_padding", o.descent_padding, {0, 0.1}, "m", "ours: 1 mm"),
          field("transit_padding", o.transit_padding, {0, 0.1}, "m", "ours: 10 mm"),
          field("approach_padding", o.approach_padding, {0, 0.1}, "m", "ours: 2 mm"),
          field("contact_zone", o.contact_zone, {0, 0.1}, "m", "ours: the last 15 mm"),
          field("approach_speed", o.approach_speed, {0.005, 1}, "m/s", "ours"),
          field("finger_speed", o.finger_speed, {0.022, 0.11}, "m/s", "Robotiq 3-finger: 22 to 110 mm/s"),
          field("grip_speed", o.grip_speed, {0.022, 0.11}, "m/s", "Robotiq 3-finger: 22 to 110 mm/s"),
          field("loosen", o.loosen, {0, 0.05}, "m", "ours"),
          field("least_threshold", o.least_threshold, {0.5, 100}, "N", "ours: 5 N; bench descent"),
          field("threshold_share", o.threshold_share, {0, 1}, "", "measured: bench descent"),
          field("early_threshold", o.early_threshold, {1, 100}, "N", "ours: inertia stays below 10 N"),
          field("least_held", o.least_held, {0, 1}, "", "ours"),
          field("largest_swing", o.largest_swing, {0.001, 1}, "m", "ours"),
          field("force_noise", o.force_noise, {0, 10}, "N", "FT300 data sheet: resolution 0.1 N"),
          field("press_pads", o.press_pads, "measured: bench hold"),
          field("alternatives", o.alternatives, {1, 100}, "", "measured: bench motion"),
          field("planning_seconds", o.planning_seconds, {0.01, 600}, "s", "ours"),
          field("seed", o.seed, {0, 2147483647}, "", "ours")};
}

}  // namespace stonestack::motion

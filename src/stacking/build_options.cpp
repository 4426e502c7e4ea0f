#include "stonestack/stacking/build_options.hpp"

#include <algorithm>

namespace stonestack::stacking {

FieldList fields(BuildOptions& o) {
  return join({nest("detection", fields(o.detection)), nest("search", fields(o.search)),
               nest("motion", fields(o.motion)),
               nest("run", {field("most_stones", o.most_stones, {0, 100}, "", "ours"),
                            field("look_distance", o.look_distance, {0.3, 1.2}, "m", "SR300: 0.2 to 1.5 m"),
                            field("placed_shift", o.placed_shift, {0.001, 0.2}, "m", "ours"),
                            field("placed_turn", o.placed_turn, {0.01, 3.2}, "rad", "ours"),
                            field("moved_shift", o.moved_shift, {0.001, 0.2}, "m", "ours"),
                            field("most_friction", o.most_friction, {0, 2}, "", "ours"),
                            field("first_rounds", o.first_rounds, {1, 1000}, "",
                                  "measured: docs/measurements.md, Search"),
                            field("sure_success", o.sure_success, {0, 1}, "", "ours"),
                            field("least_expected", o.least_expected, {0, 100}, "", "ours"),
                            field("most_failures", o.most_failures, {1, 100}, "", "paper: 1"),
                            field("refine_camera", o.refine_camera, "ours"),
                            field("measure_placed", o.measure_placed, "ours: true"),
                            field("correct_aim", o.correct_aim, "ours"),
                            field("most_turned_over", o.most_turned_over, {0, 100}, "", "paper: 0"),
                            field("most_taken_off", o.most_taken_off, {0, 100}, "", "paper: 0"),
                            field("friction_step", o.friction_step, {0.01, 2}, "", "ours"),
                            field("pick_attempts", o.pick_attempts, {1, 10}, "", "ours"),
                            field("save_states", o.save_states, "design choice: false")})});
}

std::vector<double> assumed_frictions(const BuildOptions& options) {
  std::vector<double> list{options.search.friction};
  while (list.back() < options.most_friction)
    list.push_back(std::min(options.most_friction, list.back() + options.friction_step));
  return list;
}

}  // namespace stonestack::stacking

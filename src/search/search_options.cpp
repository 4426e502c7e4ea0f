#include "stonestack/search/find_next_pose.hpp"

namespace stonestack {

FieldList fields(SearchOptions& o) {
  const double pi = 3.14159266;
  return {
      field("method", o.method, "ours: default; paper: section 3 as written"),
      field("friction", o.friction, {1e-3, 2.0}, "", "paper §4.1"),
      field("w1", o.w1, {0.0, 1e3}, "", "eq. (2), a later note: 0.179"),
      field("w2", o.w2, {0.0, 1e3}, "", "eq. (2), a later note: 0.472"),
      field("w3", o.w3, {0.0, 1e3}, "", "eq. (2), a later note: 0.094"),
      field("w4", o.w4, {0.0, 1e3}, "", "eq. (2), a later note: 0.255"),
      field("area_reference", o.area_reference, {1e-6, 1.0}, "m^2", "ours: a usual polygon"),
      field("energy_reference", o.energy_reference, {1e-9, 1e3}, "J", "ours: e_kin_stable"),
      field("distance_reference", o.distance_reference, {1e-3, 10.0}, "m", "ours: a stone's height"),
      field("si_cost", o.si_cost, "eq. (2) with its literal units and sign"),
      field("theta_init", o.theta_init, {0.0, pi}, "rad", "companion paper, weak"),
      field("attraction", o.attraction, {0.1, 1e4}, "N", "companion paper, weak"),
      field("e_kin_stable", o.e_kin_stable, {1e-9, 1e3}, "J", "measured: 20 J filters nothing"),
      field("local_solutions", o.local_solutions, {1, 1000}, "", "a later note: 5"),
      field("contact_steps", o.contact_steps, {1, 1000}, "", "a later note: 10"),
      field("restarts", o.restarts, {1, 100000}, "", "ours"),
      field("descent_step", o.descent_step, {1e-5, 0.1}, "m", "ours"),
      field("descent_rounds", o.descent_rounds, {0, 1000}, "", "ours"),
      field("descent_tolerance", o.descent_tolerance, {0.0, 1.0}, "", "ours"),
      field("grid", o.grid, {0.001, 0.02}, "m", "measured: 4 mm, refined at half"),
      field("directions", o.directions, {8, 10000}, "", "measured"),
      field("yaws", o.yaws, {1, 360}, "", "measured"),
      field("clean_height", o.clean_height, {0.0, 0.1}, "m", "measured"),
      field("settled", o.settled, {1, 10000}, "", "ours"),
      field("horizon", o.horizon, {1, 100}, "", "ours; 1: greedy"),
      field("beam", o.beam, {1, 100}, "", "measured: bench search"),
      field("rounds", o.rounds, {1, 1000}, "", "measured: bench search"),
      field("firm_margin", o.firm_margin, {0.0, 1.0}, "g", "measured: bench search --ode"),
      field("firm_rounds", o.firm_rounds, {0, 1000}, "", "measured: bench search --ode"),
      field("largest_tilt", o.largest_tilt, {0.0, pi}, "rad", "ours: free; the robot loop sets its own"),
      field("verify", o.verify, "ours"),
      field("least_margin", o.least_margin, {0.0, 1.0}, "g", "measured"),
      field("least_success", o.least_success, {0.0, 1.0}, "", "ours"),
      field("alternatives", o.alternatives, {1, 1000}, "", "ours"),
      field("verdict_seconds", o.verdict_seconds, {0.01, 600.0}, "s", "ours"),
      field("perturbations", o.perturbations, {0, 1000}, "", "ours"),
      field("perturbed_seconds", o.perturbed_seconds, {0.01, 600.0}, "s", "ours"),
      field("placement_sigma_translation", o.placement_sigma_translation, {0.0, 0.05}, "m", "ours"),
      field("placement_sigma_rotation", o.placement_sigma_rotation, {0.0, 0.5}, "rad", "ours"),
      field("com_sigma", o.com_sigma, {0.0, 0.02}, "m", "ours"),
      field("threads", o.threads, {0, 1024}, "", "0: all cores"),
      field("budget", o.budget, {0.0, 1e6}, "s", "0: none"),
      field("seed", o.seed, {0, 2147483647}, "", ""),
      field("trace", o.trace, "keeps every candidate"),
  };
}

}  // namespace stonestack

#include "stonestack/experiment/simulated_run.hpp"

#include <sstream>

#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::experiment {

std::vector<Variant> cell_variants() {
  const std::vector<std::string> easy{"simulation.cell=ideal"};
  const auto only = [&](const std::string& name, const std::vector<std::string>& hard) {
    Variant variant{name, easy};
    variant.assignments.insert(variant.assignments.end(), hard.begin(), hard.end());
    return variant;
  };
  return {{"as it is", {}},
          only("no error at all", {}),
          only("sensor noise only", {"simulation.sensor_noise=true"}),
          only("hand-eye error only",
               {"simulation.hand_eye_translation=0.001", "simulation.hand_eye_rotation=0.005236"}),
          only("arm error only", {"simulation.arm_repeatability=0.0001", "simulation.arm_residual=0.001"}),
          only("mass and centre only", {"simulation.mass_error=0.02", "simulation.com_error=0.002"}),
          only("friction 0.35 to 0.65 only", {"simulation.friction_spread=0.15"}),
          only("fingers locked only", {"simulation.regrip=false"}),
          only("pads grip with 0.4 only", {"simulation.pad_friction=0.4"}),
          only("pads half as stiff only", {"simulation.pad_stiffness=7.5e7"}),
          only("force 20 ms late only", {"simulation.force_delay=0.02"}),
          only("stones 5 mm apart only", {"simulation.clearance=0.005"}),
          only("scans 0.3 mm off only", {"simulation.scan_error=0.0003"}),
          only("friction 0.2 only", {"simulation.friction=0.2"}),
          only("friction 0.1 only", {"simulation.friction=0.1"})};
}

std::vector<Variant> design_variants() {
  return {{"as it is", {}},
          {"paper's search", {"search.method=paper"}},
          {"no look-ahead", {"search.horizon=1"}},
          {"let go without feeling",
           {"motion.descent_past=0", "motion.min_threshold=100", "motion.early_threshold=100"}},
          {"placed stone not measured", {"run.measure_placed=false"}},
          {"first failure ends the run", {"run.max_failures=1"}},
          {"no stone unstacked", {"run.max_unstacked=0"}},
          {"no stone reoriented", {"run.max_reoriented=0"}},
          {"friction 0.1 only", {"run.max_friction=0.1"}},
          {"grasps by three contacts", {"motion.press_pads=false"}},
          {"no perturbed verdicts", {"search.perturbations=0"}},
          {"aim not corrected", {"run.correct_aim=false"}}};
}

Variant parse_variant(const std::string& text) {
  const auto colon = text.find(':');
  require(colon != std::string::npos, "--variant expects 'NAME: OPTION=VALUE, ...', got '", text, "'");
  Variant variant{text.substr(0, colon), {}};
  std::istringstream list(text.substr(colon + 1));
  for (std::string assignment; std::getline(list, assignment, ',');) {
    std::erase(assignment, ' ');
    if (!assignment.empty()) variant.assignments.push_back(assignment);
  }
  return variant;
}

namespace {

void check_seeds(const SimulatedRun& run, int seed) {
  for (const int set :
       {run.build.search.seed, run.build.detection.seed, run.build.motion.seed, run.simulation.seed})
    require(set == seed,
            "run k of an experiment with --seed S has 1000 S + k for its seed, the planner's and ",
            "the cell's; ", set, " for a part of it would have no effect (`stonestack run` takes one)");
}

}  // namespace

void check_variants(const std::vector<Variant>& variants, const SimulatedRun& run, int seed) {
  check_seeds(run, seed);
  for (const Variant& variant : variants) {
    SimulatedRun changed = run;
    for (const std::string& assignment : variant.assignments) set_field(fields(changed), assignment);
    (void)options_of(changed.build.detection.method);  // both throw for one that there is not
    (void)options_of_cell(changed.simulation.cell);
    check_seeds(changed, seed);
  }
}

}  // namespace stonestack::experiment
